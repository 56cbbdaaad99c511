// The list of what happened: the moments, or all entries of a kind, searched; each opens as it stands in the log.

const ENTRIES_SHOWN = 400; // in the list; all moments are on the time line

/** @typedef {{t: number, i: number, kind: string, sign: Sign, says: string}} Listed */

/** @type {number[]} when the entries of the list were */
let listTimes = [];

/** @param {App} app */
function listenToEntries(app) {
  for (const id of ["kinds", "search"]) byId(id).addEventListener("input", () => (showMoments(app), app.show()));
}

/** @param {App} app */
function showMoments(app) {
  const { run } = app;
  const kinds = /** @type {HTMLSelectElement} */ (byId("kinds"));
  const known = ["", "*", ...[...run.kinds.keys()].sort()];
  if (kinds.options.length !== known.length) {
    const { value } = kinds;
    const names = ["moments", "all entries", ...known.slice(2)];
    kinds.replaceChildren(...known.map((kind, place) => element("option", { value: kind }, names[place])));
    kinds.value = known.includes(value) ? value : "";
  }
  const words = /** @type {HTMLInputElement} */ (byId("search")).value.trim().toLowerCase().split(/\s+/).filter(Boolean);
  const found = foundIn(run, kinds.value, words);
  const isPlain = kinds.value === "" && words.length === 0;
  const told = (isPlain ? rarestFirst(found) : found)
    .slice(0, ENTRIES_SHOWN)
    .sort((one, other) => one.t - other.t || one.i - other.i);
  listTimes = told.map(({ t }) => t);
  byId("moments").replaceChildren(...told.map((each) => itemOf(app, each)));
  byId("moments-about").textContent = isPlain
    ? told.length < found.length ? `${told.length} of ${found.length} moments, of the rarest kinds.` : ""
    : told.length < found.length ? `the first ${told.length} of ${found.length} found` : `${found.length} found`;
}

/** @param {Run} run @param {string} kind empty: moments; `*`: all @param {string[]} words all are to be in it @returns {Listed[]} in order of time */
function foundIn(run, kind, words) {
  const has = (/** @type {string} */ text) => words.every((word) => text.toLowerCase().includes(word));
  if (kind === "") return words.length ? run.moments.all.filter(({ kind, says }) => has(`${kind} ${says}`)) : run.moments.all;
  /** @type {Listed[]} */
  const found = [];
  for (const each of kind === "*" ? run.kinds.keys() : [kind]) {
    const rows = run.kind(each);
    const sign = SIGNS[each] ?? { sign: "·", name: each, row: 3 };
    for (let row = 0; row < (rows.t?.length ?? 0); row++) {
      const says = rows.says?.[row] ?? fieldsOf(rows, row);
      if (has(`${each} ${rows.source[row]} ${says}`))
        found.push({ t: rows.t[row], i: rows.i[row], kind: each, sign, says: rows.says?.[row] ?? `${rows.source[row]} ${each} ${says.slice(0, FIELDS_SHOWN)}` });
    }
  }
  return found.sort((one, other) => one.t - other.t || one.i - other.i);
}

const NOT_OF_THE_LOG = new Set(["i", "t", "source", "says", "ends"]); // what a batch adds
const FIELDS_SHOWN = 110; // letters of an entry without a sentence

/** @param {Columns} rows @param {number} row */
function fieldsOf(rows, row) {
  const fields = Object.keys(rows).filter((name) => !NOT_OF_THE_LOG.has(name) && !Array.isArray(rows[name][row]));
  return fields.map((name) => `${name} ${rows[name][row]}`).join(", ");
}

/** The entry as it stands in the log, but for its hlc and n. @param {Run} run @param {Listed} entry */
function rawOf(run, { kind, i }) {
  const rows = run.kind(kind);
  const row = rows.i.indexOf(i);
  /** @type {Record<string, unknown>} */
  const raw = { kind, t_s: rows.t[row], source: rows.source[row] };
  for (const name of Object.keys(rows)) if (!NOT_OF_THE_LOG.has(name)) raw[name] = rows[name][row];
  return JSON.stringify(raw, (_, value) => (Array.isArray(value) && value.every(Number.isFinite) ? `[${value.join(", ")}]` : value), 1);
}

/** @param {App} app @param {Listed} entry */
function itemOf(app, entry) {
  const link = element(
    "button",
    { type: "button" },
    element("time", {}, entry.t.toFixed(2)),
    element("i", { class: `row${entry.sign.row}` }, entry.sign.sign),
    element("span", {}, entry.says),
  );
  link.addEventListener("click", () => app.seek(entry.t));
  const opens = element("button", { type: "button", class: "raw", "aria-expanded": "false", title: "the entry in the log" }, "{ }");
  const item = element("li", {}, link, opens);
  opens.addEventListener("click", () => {
    const open = item.querySelector("pre");
    if (open) open.remove();
    else item.append(element("pre", {}, rawOf(app.run, entry)));
    opens.setAttribute("aria-expanded", String(!open));
  });
  return item;
}

/** Mark the newest entry and have it in sight of the list. @param {App} app */
function markMoment(app) {
  const list = byId("moments");
  const newest = /** @type {HTMLElement | undefined} */ (
    list.children[placeAt(listTimes, listTimes.length, app.time + 1e-9)]?.firstElementChild ?? undefined
  );
  if (mark(list, newest) && newest) list.scrollTop = newest.offsetTop - list.clientHeight / 2;
}

/** What the run was asked for: its scenario and its fault plan. @param {App} app */
function showAsked(app) {
  const asked = app.run.subject?.asked ?? {};
  const key = JSON.stringify(asked);
  if (key === askedShown) return; // what a reader has opened stays open
  askedShown = key;
  byId("asked").replaceChildren(
    ...Object.entries(asked).map(([name, text]) =>
      element("details", {}, element("summary", {}, name), element("pre", {}, String(text))),
    ),
    ...("faults.toml" in asked ? [] : [element("p", {}, "No fault plan.")]),
  );
}

let askedShown = "";
