// The tables of the page: steps with their distances, the moments of the run, and the books of messages.

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
  const rows = rowsOf(run).map(({ step, position }) => {
    const texts = step ? stepCells(run, step) : ["", position.t_s.toFixed(2), `r${position.robot}`, "", ""];
    const cells = [...texts, metres(position?.clearance_m, 3).replace(" m", "")].map((text) =>
      element("td", {}, text),
    );
    cells.push(...distanceCells(position, paper?.[run.positions.indexOf(position)], obstacles));
    const link = element("button", { type: "button" }, step ? String(step.step) : "start");
    link.addEventListener("click", () => app.seek(step ? step.from : position.t_s));
    return element("tr", {}, element("th", { scope: "row" }, link), ...cells);
  });
  byId("steps").replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
  const left = run.scenario.obstacle.length - obstacles;
  byId("steps-about").textContent =
    "Distance from the leader's centre to each obstacle where each step ended [m], the nearest underlined" +
    (paper ? "; small: what the paper's Table I prints, whose position 1 is the start." : ".") +
    (left > 0 ? ` ${left} more obstacles are left out.` : "") +
    (run.steps.some(({ row }) => leadsAway(run, run.kind("step.planned"), row))
      ? " *: something has come nearer than that, and the step leads away from it."
      : "");
}

/**
 * Whether a step promises less than the run requires: it begins nearer than that to something that has come up to the
 * robot, and leads away. @param {Run} run @param {Columns} plans @param {number} row
 */
function leadsAway(run, plans, row) {
  const promised = plans.promised_clearance_m[row];
  return promised !== null && promised < (run.subject?.clearance_m_required ?? 0);
}

/** The start, and then a row for each step. @param {Run} run @returns {{step?: Step, position?: any}[]} */
function rowsOf(run) {
  const start = run.positions.find((each) => each.step === 0);
  return [
    ...(start ? [{ position: start }] : []),
    ...run.steps.map((step) => ({ step, position: run.positions[step.position] })),
  ];
}

/** @param {Run} run @param {Step} step */
function stepCells(run, step) {
  const plans = run.kind("step.planned");
  return [
    step.from.toFixed(2),
    step.end === "" ? "under way" : step.to.toFixed(2) + (step.end === "finished" ? "" : ` ${step.end}`),
    `r${step.robot}`,
    plans.length_m[step.row].toFixed(3),
    (plans.promised_clearance_m[step.row]?.toFixed(3) ?? "–") + (leadsAway(run, plans, step.row) ? " *" : ""),
  ];
}

/** @param {any} position @param {number[] | undefined} printed @param {number} count */
function distanceCells(position, printed, count) {
  const nearest = position ? Math.min(...position.distances_m) : NaN;
  return Array.from({ length: count }, (_, column) => {
    const here = position?.distances_m[column];
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
  const newest = newestStep(app.run, app.time);
  const place = rowsOf(app.run).findIndex(({ step }) => step === newest); // without one, that of the start
  mark(byId("steps"), body?.children[place]);
}

const MOMENTS_SHOWN = 400; // in the list; all are on the time line

/** @type {number[]} when the moments of the list were */
let momentTimes = [];

/** @param {App} app */
function showMoments(app) {
  const { all } = app.run.moments;
  const told = rarestFirst(all)
    .slice(0, MOMENTS_SHOWN)
    .sort((one, other) => one.t - other.t);
  momentTimes = told.map((moment) => moment.t);
  byId("moments").replaceChildren(
    ...told.map((moment) => {
      const link = element(
        "button",
        { type: "button" },
        element("time", {}, moment.t.toFixed(2)),
        element("i", { class: `row${moment.sign.row}` }, moment.sign.sign),
        element("span", {}, sentence(moment), why(app.run, moment)),
      );
      link.addEventListener("click", () => app.seek(moment.t));
      return element("li", {}, link);
    }),
  );
  byId("moments-about").textContent =
    told.length < all.length ? `${told.length} of ${all.length}, those of the rarest kinds.` : "";
}

/** Why a step promises less than it has to keep. @param {Run} run @param {Moment} moment */
function why(run, { kind, rows, i }) {
  const isSo = kind === "step.planned" && leadsAway(run, rows, i);
  return isSo ? ": something has come nearer, and it leads away from that" : "";
}

/** Mark the newest moment and have it in sight of the list. @param {App} app */
function markMoment(app) {
  const list = byId("moments");
  const newest = /** @type {HTMLElement | undefined} */ (
    list.children[placeAt(momentTimes, momentTimes.length, app.time + 1e-9)]?.firstElementChild ?? undefined
  );
  if (mark(list, newest) && newest) list.scrollTop = newest.offsetTop - list.clientHeight / 2;
}

/** @param {App} app */
function showMessages(app) {
  const books = app.run.losses
    .told()
    .filter(([, { sent, received }]) => sent || received)
    .sort(([one], [other]) => one.localeCompare(other, "en", { numeric: true }));
  const head = element(
    "tr",
    {},
    ...["link", "sent", "received", "taken by faults", "lost"].map((name) =>
      element("th", { scope: "col" }, name),
    ),
  );
  const rows = books.map(([link, book]) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, link.replace(">", "→")),
      ...bookCells(book).map((text) => element("td", {}, text)),
    ),
  );
  byId("messages").replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
  byId("messages-about").textContent = books.length
    ? "State messages of each link, by the books that its two robots closed with. A process that died closed none."
    : "Robots close their books at the end of a run.";
}

/** @param {Told} book */
function bookCells({ sent, received, injected }) {
  if (sent === null || received === null)
    return [String(sent ?? "–"), String(received ?? "–"), "–", "not known: its process died"];
  const lost = sent > 0 ? ((100 * (sent - received)) / sent).toFixed(1) : "0.0";
  return [String(sent), String(received), String(injected), `${lost} %`];
}
