// The strand's steps, each under the number that the log gives it: when it was driven, and how it ended.

class Step {
  /** @param {Run} run @param {any} row as a batch has it */
  constructor(run, row) {
    this.run = run;
    this.row = row;
    /** @type {number} */
    this.step = row.step;
    /** @type {number} */
    this.from = row.from_s;
    /** @type {string} "finished", "abandoned", "broken off", or "" while it is under way */
    this.end = row.end;
  }

  get to() {
    return this.row.to_s ?? this.run.end;
  }
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
  if (run.start) times.add(run.start.t_s);
  return [...times].sort((one, other) => one - other);
}

/**
 * When a run was as far in its steps as another at a time: as far into the step of the same number, or between two.
 * @param {Run} from @param {Run} to @param {number} time
 */
function aligned(from, to, time) {
  return alignment(from, to)(time);
}

/** The same for many times. @param {Run} from @param {Run} to @returns {(time: number) => number} */
function alignment(from, to) {
  const [here, there] = [from, to].map((run) => new Map(run.steps.map((each) => [each.step, each])));
  const pairs = [[0, 0]];
  for (const [step, one] of here) {
    const other = there.get(step);
    if (other) pairs.push([one.from, other.from], [one.to, other.to]);
  }
  const last = pairs[pairs.length - 1];
  pairs.push([Math.max(from.end, last[0]), Math.max(to.end, last[1])]);
  return (time) => {
    const next = pairs.findIndex((each, i) => i > 0 && each[0] > time);
    const place = next < 0 ? pairs.length - 1 : next;
    return between(pairs[place - 1], pairs[place], time);
  };
}

/** @param {number[]} before @param {number[]} next @param {number} time */
function between(before, next, time) {
  const span = next[0] - before[0];
  return span > 0 ? before[1] + ((time - before[0]) / span) * (next[1] - before[1]) : next[1];
}
