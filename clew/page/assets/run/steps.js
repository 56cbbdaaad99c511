// The strand's steps, each under the number that the log gives it: when it was driven, and how it ended.

/**
 * @typedef {{step: number, robot: number, from: number, to: number, end: string, row: number, position: number}} Step
 *   `end`: "finished", "abandoned", "broken off", or "" while it is under way; `row` in "step.planned", `position` in
 *   `Run.positions`, -1: nobody has said where it ended
 */

/** All steps that leaders have planned; those of robots that join are their own. @param {Run} run @returns {Step[]} */
function stepsOf(run) {
  const plans = run.kind("step.planned");
  const rows = [...(plans.t ?? []).keys()].filter((row) => !plans.joins[row]);
  rows.sort((one, other) => plans.t[one] - plans.t[other]);
  return rows.map((row, place) => {
    const [from, step, robot] = [plans.t[row], plans.step[row], robotOf(plans.source[row])];
    const next = rows[place + 1];
    const end = endOf(run, { step, robot, from, next: next === undefined ? Infinity : plans.t[next] });
    return { step, robot, from, row, ...end };
  });
}

/** @param {Run} run @param {{step: number, robot: number, from: number, next: number}} of */
function endOf(run, { step, robot, from, next }) {
  const position = run.positions.findIndex(
    (each) => each.step === step && each.robot === robot && each.t_s >= from,
  );
  if (position >= 0) return { to: Math.min(run.positions[position].t_s, next), end: "finished", position };
  const dropped = run.kind("step.abandoned");
  const at = (dropped.t ?? []).findIndex(
    (t, i) => t >= from && dropped.step[i] === step && robotOf(dropped.source[i]) === robot,
  );
  if (at >= 0) return { to: Math.min(dropped.t[at], next), end: "abandoned", position };
  const lane = run.lanes.get(robot);
  const dead = lane ? lane.t.find((t, i) => t >= from && lane.state[i] === "dead") : undefined;
  const to = Math.min(dead ?? Infinity, next);
  return to < Infinity ? { to, end: "broken off", position } : { to: run.end, end: "", position };
}

/** The newest step by then, driven still or not. @param {Run} run @param {number} t @returns {Step | undefined} */
function newestStep(run, t) {
  return run.steps.findLast((each) => each.from <= t);
}

/** What is said of the steps at a time. @param {Run} run @param {number} t */
function stepWords(run, t) {
  const newest = newestStep(run, t);
  if (!newest) return "no step yet";
  return `step ${newest.step}${newest.end && newest.to <= t ? ` ${newest.end}` : ""}`;
}

/** When steps began and ended, in order. @param {Run} run @returns {number[]} */
function boundariesOf(run) {
  const times = new Set(run.steps.flatMap((each) => (each.end ? [each.from, each.to] : [each.from])));
  for (const { t_s } of run.positions) times.add(t_s);
  return [...times].sort((one, other) => one - other);
}

/**
 * When a run was as far in its steps as another at a time: as far into the step of the same number, or between two.
 * @param {Run} from @param {Run} to @param {number} time
 */
function aligned(from, to, time) {
  const [here, there] = [from, to].map((run) => new Map(run.steps.map((each) => [each.step, each])));
  let before = [0, 0];
  for (const [step, one] of here) {
    const other = there.get(step);
    if (!other) continue;
    for (const next of [
      [one.from, other.from],
      [one.to, other.to],
    ]) {
      if (next[0] > time) return between(before, next, time);
      before = next;
    }
  }
  return between(before, [Math.max(from.end, before[0]), Math.max(to.end, before[1])], time);
}

/** @param {number[]} before @param {number[]} next @param {number} time */
function between(before, next, time) {
  const span = next[0] - before[0];
  return span > 0 ? before[1] + ((time - before[0]) / span) * (next[1] - before[1]) : next[1];
}
