// The tables of the page: steps with their distances, the moments of the run, and the books of messages.

const COLUMNS_MAX = 16; // obstacles in the step table: more would be read by nobody

/** The step table, in the form of the paper's Table I. @param {App} app */
function showSteps(app) {
  const { run } = app;
  const paper = run.scenario.table_m;
  const obstacles = Math.min(run.scenario.obstacle.length, COLUMNS_MAX);
  const names = [
    "position",
    "t [s]",
    "leader",
    "length",
    "promised",
    "kept",
    ...Array.from({ length: obstacles }, (_, i) => `obstacle ${i + 1}`),
  ];
  const head = element("tr", {}, ...names.map((name) => element("th", { scope: "col" }, name)));
  const rows = run.positions.map((position, i) => {
    const planned = stepBefore(run, position);
    const cells = [
      position.t_s.toFixed(2),
      `r${position.robot}`,
      planned ? planned.length_m.toFixed(3) : "–",
      planned?.promised_clearance_m == null ? "–" : planned.promised_clearance_m.toFixed(3),
      position.clearance_m == null ? "–" : position.clearance_m.toFixed(3),
    ].map((text) => element("td", {}, text));
    const nearest = Math.min(...position.distances_m);
    for (let column = 0; column < obstacles; column++) {
      const here = position.distances_m[column];
      if (here === undefined) continue;
      const cell = element("td", here === nearest ? { class: "nearest" } : {}, here.toFixed(3));
      if (paper?.[i]?.[column] !== undefined) cell.append(element("small", {}, paper[i][column].toFixed(3)));
      cells.push(cell);
    }
    const link = element("button", { type: "button" }, String(i + 1));
    link.addEventListener("click", () => app.seek(position.t_s));
    return element("tr", {}, element("th", { scope: "row" }, link), ...cells);
  });
  byId("steps").replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
  const left = run.scenario.obstacle.length - obstacles;
  byId("steps-about").textContent =
    "Distance from the leader's centre to each obstacle at each switching position [m], the nearest underlined" +
    (paper ? "; small: what the paper's Table I prints." : ".") +
    (left > 0 ? ` ${left} more obstacles are left out.` : "");
}

/** The plan of the step that ended at a position. @param {Run} run @param {any} position */
function stepBefore(run, position) {
  return position.step === 0 ? null : stepAt(run, position.robot, position.t_s - 1e-6);
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

/** Mark the row of the newest position. @param {App} app */
function markStep(app) {
  const body = byId("steps").lastElementChild;
  mark(byId("steps"), body?.children[positionAt(app.run, app.time)]);
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
        element("span", {}, sentence(moment)),
      );
      link.addEventListener("click", () => app.seek(moment.t));
      return element("li", {}, link);
    }),
  );
  byId("moments-about").textContent =
    told.length < all.length ? `${told.length} of ${all.length}, those of the rarest kinds.` : "";
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
  const books = [...app.run.losses.books]
    .filter(([, book]) => book.sent > 0)
    .sort(([one], [other]) => one.localeCompare(other, "en", { numeric: true }));
  const head = element(
    "tr",
    {},
    ...["link", "sent", "received", "taken by faults", "lost"].map((name) =>
      element("th", { scope: "col" }, name),
    ),
  );
  const rows = books.map(([link, { sent, received, injected, closed }]) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, link.replace(">", "→")),
      ...(closed
        ? [
            String(sent),
            String(received),
            String(injected),
            `${((100 * Math.max(sent - received, 0)) / sent).toFixed(1)} %`,
          ]
        : [String(sent), "–", "–", "–"]
      ).map((text) => element("td", {}, text)),
    ),
  );
  byId("messages").replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
  byId("messages-about").textContent = books.length
    ? "State messages of each link, by the books that its two robots closed with; a robot that died closed none."
    : "Robots close their books at the end of a run.";
}
