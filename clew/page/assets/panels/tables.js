// The tables of the page: steps with their distances, and the books of messages.

const COLUMNS_MAX = 16; // obstacles in the step table: more would be read by nobody

/** The step table, in the form of the paper's Table I. @param {App} app */
function showSteps(app) {
  const { run } = app;
  const paper = run.scenario.table_m;
  const obstacles = Math.min(run.scenario.obstacle.length, COLUMNS_MAX);
  const names = ["step", "from [s]", "to [s]", "leader", "length", "promised", "kept"];
  const head = element("tr", {}, ...names.map((name) => element("th", { scope: "col" }, name)));
  for (let i = 1; i <= obstacles; i++)
    head.append(element("th", { scope: "col", title: `distance to obstacle ${i}` }, `to ${i}`));
  const rowOf = (
    /** @type {string} */ name,
    /** @type {number} */ time,
    /** @type {string[]} */ texts,
    /** @type {HTMLElement[]} */ distances,
  ) => {
    const link = element("button", { type: "button" }, name);
    link.addEventListener("click", () => app.seek(time));
    const cells = texts.map((text) => element("td", {}, text));
    return element("tr", {}, element("th", { scope: "row" }, link), ...cells, ...distances);
  };
  const rows = run.steps.map(({ step, from, row }) => {
    const printed = row.position ? paper?.[row.position] : undefined;
    return rowOf(String(step), from, stepCells(row), distanceCells(row.distances_m, printed, obstacles));
  });
  if (run.start) {
    const { t_s, robot, distances_m } = run.start;
    const texts = ["", t_s.toFixed(2), `r${robot}`, "", "", "–"];
    rows.unshift(rowOf("start", t_s, texts, distanceCells(distances_m, paper?.[0], obstacles)));
  }
  byId("steps").replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
  const left = run.scenario.obstacle.length - obstacles;
  byId("steps-about").textContent =
    "Distance from the leader's centre to each obstacle at the end of each step [m], the nearest underlined" +
    (paper ? "; small: the values of the paper's Table I, whose position 1 is the start." : ".") +
    (left > 0 ? ` ${left} more obstacles are not shown.` : "") +
    (run.steps.some(({ row }) => row.leads_away)
      ? " *: an obstacle has come nearer than this, and the step leads away from it."
      : "");
}

/** @param {any} row of a step, as a batch has it */
function stepCells(row) {
  return [
    row.from_s.toFixed(2),
    row.end === "" ? "under way" : row.to_s.toFixed(2) + (row.end === "finished" ? "" : ` ${row.end}`),
    `r${row.robot}`,
    row.length_m.toFixed(3),
    (row.promised_m?.toFixed(3) ?? "–") + (row.leads_away ? " *" : ""),
    row.clearance_m?.toFixed(3) ?? "–",
  ];
}

/** @param {number[] | undefined} distances @param {number[] | undefined} printed @param {number} count */
function distanceCells(distances, printed, count) {
  const nearest = Math.min(...(distances ?? []));
  return Array.from({ length: count }, (_, column) => {
    const here = distances?.[column];
    const cell = element("td", here === nearest ? { class: "nearest" } : {}, here?.toFixed(3) ?? "–");
    if (printed?.[column] !== undefined) cell.append(element("small", {}, printed[column].toFixed(3)));
    return cell;
  });
}

/**
 * Marks one of the children of a list as the newest, and moves the mark only when it has to.
 * @param {HTMLElement} list @param {Element | undefined} newest
 */
function mark(list, newest) {
  const before = marked.get(list);
  if (before === newest) return false;
  before?.removeAttribute("aria-current");
  newest?.setAttribute("aria-current", "true");
  marked.set(list, newest);
  return true;
}

/** @type {Map<HTMLElement, Element | undefined>} */
const marked = new Map();

/** Mark the row of the newest step. @param {App} app */
function markStep(app) {
  const body = byId("steps").lastElementChild;
  const place = app.run.steps.findLastIndex((each) => each.from <= app.time); // -1: the start
  mark(byId("steps"), body?.children[place + (app.run.start ? 1 : 0)]);
}

/** @param {App} app */
function showMessages(app) {
  const books = app.run.losses.books.filter(({ sent, received }) => sent || received);
  const head = element(
    "tr",
    {},
    ...["link", "sent", "received", "removed by faults", "lost"].map((name) =>
      element("th", { scope: "col" }, name),
    ),
  );
  const rows = books.map((book) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, `${book.sender} → ${book.receiver}`),
      ...bookCells(book).map((text) => element("td", {}, text)),
    ),
  );
  byId("messages").replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
  byId("messages-about").textContent = books.length
    ? "State messages of each link, from the final counts of its two robots. A process that died left no counts."
    : "Robots report their message counts at the end of a run.";
}

/** @param {Book} book */
function bookCells({ sent, received, injected }) {
  if (sent === null || received === null)
    return [String(sent ?? "–"), String(received ?? "–"), "–", "not known: its process died"];
  const lost = sent > 0 ? ((100 * (sent - received)) / sent).toFixed(1) : "0.0";
  return [String(sent), String(received), String(injected), `${lost} %`];
}
