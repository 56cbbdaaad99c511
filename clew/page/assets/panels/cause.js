// Why a run failed, in the sentence of its verdict: its times lead to their moments.

const SAID_S = 0.06; // a verdict rounds its times to 0.1 s

/** Reasons that name no time, and where they are seen. @type {[RegExp, (run: Run) => number | undefined, string][]} */
const UNDATED = [
  [/^no way for/, (run) => firstOf(run, "robot.stranded"), "stranded"],
  [/^every robot has died/, (run) => run.moments.all.findLast(({ kind }) => kind === "robot.died")?.t, "the last death"],
  [/^(the time was up|the goal|\d+ of)/, lastMotion, "nothing moved after"],
];

/** @param {Run} run @param {string} kind */
function firstOf(run, kind) {
  return run.moments.all.find((each) => each.kind === kind)?.t;
}

/** When a body moved last. @param {Run} run */
function lastMotion(run) {
  let last = 0;
  for (const body of run.bodies.values()) {
    let i = body.t.length - 2;
    while (i >= 0 && !body.movesFrom(i)) i--;
    if (i >= 0) last = Math.max(last, body.t.data[i + 1]);
  }
  return last;
}

/** The sentence of the verdict, with its links. @param {App} app @returns {(Node | string)[]} */
function reasonOf(app) {
  const { run } = app;
  const { verdict } = run;
  const said = [verdict?.reason, run.shortfall].filter(Boolean).join(". ");
  if (!verdict || verdict.ok) return [said];
  const who = Number(/robot (\d+)/.exec(said)?.[1] ?? 0);
  const parts = said.split(/(t=\d+(?:\.\d+)? s)/);
  const linked = parts.map((part, i) => (i % 2 ? linkTo(app, part, momentNear(run, parseFloat(part.slice(2)), who), who) : part));
  const [, when, word] = UNDATED.find(([pattern]) => pattern.test(said)) ?? [];
  const t = parts.length === 1 ? when?.(run) : undefined;
  return t === undefined ? linked : [...linked, ` (${word}: `, linkTo(app, `t=${t.toFixed(1)} s`, t, who), ")"];
}

/** The moment that a time of the verdict is of; what went wrong goes before all else. @param {Run} run @param {number} t @param {number} robot */
function momentNear(run, t, robot) {
  const near = run.moments.all.filter((each) => Math.abs(each.t - t) < SAID_S && each.sign.row === 0);
  const broken = near.find(({ kind, says }) => kind === "promise.broken" && says.includes(`r${robot}`));
  return (broken ?? near[0])?.t ?? t;
}

/** @param {App} app @param {string} text @param {number} t @param {number} robot 0: of none */
function linkTo(app, text, t, robot) {
  const link = element("a", { href: `#t=${t.toFixed(2)}${robot ? `&robot=${robot}` : ""}`, title: "show this moment" }, text);
  link.addEventListener("click", (event) => {
    event.preventDefault();
    if (app.run.bodies.has(robot)) app.robot = robot;
    app.seek(t);
  });
  return link;
}
