// Two runs: in what they differ, from what was asked for to the last step.

const SAME_M = 0.0005; // as much as the tables show

/** @typedef {{what: string, here: string, there: string, t: number | null}} Difference `t`: where it is seen, in the first run */

/** @param {App} app */
function showDifferences(app) {
  const section = byId("differences-section");
  section.hidden = app.runs.length !== 2 || !app.runs.every(({ subject }) => subject);
  if (section.hidden) return;
  const [one, other] = app.runs;
  const asked = askedApart(one, other);
  const steps = stepsApart(one, other);
  const head = element("tr", {}, ...["", "A", "B"].map((name) => element("th", { scope: "col" }, name)));
  const rows = [...asked, ...endsApart(one, other), ...steps].map(({ what, here, there, t }) => {
    const link = element("button", { type: "button" }, what);
    if (t !== null) link.addEventListener("click", () => app.seek(app.focus === 0 ? t : aligned(one, other, t)));
    return element("tr", {}, element("th", { scope: "row" }, t === null ? what : link), element("td", {}, here), element("td", {}, there));
  });
  byId("differences").replaceChildren(element("thead", {}, head), element("tbody", {}, ...rows));
  const started = asked.length ? `Started differently: ${asked.map(({ what }) => what).join(", ")}. ` : "Asked for the same. ";
  byId("differences-about").textContent =
    started + (steps.length ? `The first step that differs is ${steps[0].what}.` : "No switching step differs.");
}

/** @param {Run} one @param {Run} other @returns {Difference[]} */
function askedApart(one, other) {
  const facts = (/** @type {Run} */ { subject }) => ({
    scenario: subject.scenario?.name,
    seed: subject.seed,
    law: subject.scenario?.law?.law,
    robots: subject.scenario?.fleet?.robots,
    speed: subject.speed,
    ...Object.fromEntries(Object.entries(subject.asked ?? {}).map(([name, text]) => [name, `${String(text).split("\n").length} lines`])),
  });
  const [here, there] = [facts(one), facts(other)].map((each) => /** @type {Record<string, unknown>} */ (each));
  const isApart = (/** @type {string} */ name) =>
    name.includes(".") ? one.subject.asked?.[name] !== other.subject.asked?.[name] : here[name] !== there[name];
  const say = (/** @type {unknown} */ value) => String(value ?? "–");
  return [...new Set([...Object.keys(here), ...Object.keys(there)])]
    .filter(isApart)
    .map((name) => ({ what: name, here: say(here[name]), there: say(there[name]), t: null }));
}

/** How the runs ended, as far as their tiles differ. @param {Run} one @param {Run} other @returns {Difference[]} */
function endsApart(one, other) {
  const endOf = (/** @type {Run} */ run) => {
    const end = new Map([["verdict", String(run.verdict?.reason ?? "–")]]);
    for (const [name, value] of figuresOf(run)) end.set(name, value);
    return end;
  };
  const [here, there] = [endOf(one), endOf(other)];
  return [...new Set([...here.keys(), ...there.keys()])]
    .filter((name) => here.get(name) !== there.get(name))
    .map((name) => ({ what: name, here: here.get(name) ?? "–", there: there.get(name) ?? "–", t: null }));
}

/** Switching steps that one run lacks, or whose leader or target differ. @param {Run} one @param {Run} other @returns {Difference[]} */
function stepsApart(one, other) {
  const [here, there] = [plansOf(one), plansOf(other)];
  const keys = [...new Set([...here.keys(), ...there.keys()])].sort((a, b) => parseFloat(a) - parseFloat(b));
  return keys.flatMap((key) => {
    const [a, b] = [here.get(key), there.get(key)];
    const apart = a && b ? Math.hypot(a.to[0] - b.to[0], a.to[1] - b.to[1]) : Infinity;
    if (a?.robot === b?.robot && apart < SAME_M) return [];
    const say = (/** @type {typeof a} */ plan) => (plan ? `r${plan.robot} to (${plan.to.map((each) => each.toFixed(2)).join(", ")})` : "–");
    const far = apart < Infinity ? `, ${metres(apart, 3)} away` : "";
    return [{ what: `step ${key.split(" ")[0]}`, here: say(a), there: say(b) + far, t: a ? a.t : null }];
  });
}

/** The plans of the strand by the step's number and, where it was planned again, by count. @param {Run} run */
function plansOf(run) {
  const rows = run.kind("step.planned");
  /** @type {Map<string, {robot: number, to: [number, number], t: number}>} */
  const plans = new Map();
  for (let row = 0; row < (rows.t?.length ?? 0); row++) {
    if (rows.joins[row]) continue;
    let count = 1;
    while (plans.has(`${rows.step[row]} ${count}`)) count++;
    plans.set(`${rows.step[row]} ${count}`, { robot: robotOf(rows.source[row]), to: pair(rows.target[row]), t: rows.t[row] });
  }
  return plans;
}
