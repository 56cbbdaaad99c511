// Playing: time goes on by itself, or by keys, step by step.

const SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 30];

class Player {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.isPlaying = false;
    this.speed = 1;
    this.before = 0;
  }

  toggle() {
    if (!this.isPlaying && this.app.time >= this.app.run.end) this.app.seek(0);
    this.isPlaying = !this.isPlaying;
    this.app.follows = false;
    this.before = performance.now();
    if (this.isPlaying) requestAnimationFrame((now) => this.tick(now));
    this.app.show();
  }

  /** @param {number} now ms */
  tick(now) {
    if (!this.isPlaying) return;
    const { app } = this;
    app.seek(app.time + (this.speed * Math.max(now - this.before, 0)) / 1000);
    this.before = now;
    if (app.time >= app.run.end && app.run.ended) this.isPlaying = false;
    else requestAnimationFrame((then) => this.tick(then));
  }

  /** @param {number} by places in `SPEEDS` */
  faster(by) {
    const place = Math.min(Math.max(SPEEDS.indexOf(this.speed) + by, 0), SPEEDS.length - 1);
    this.speed = SPEEDS[place];
    this.app.show();
  }

  /** To where the next step begins or ends, or the one before. @param {number} by 1 or -1 */
  step(by) {
    const times = boundariesOf(this.app.run);
    const { time } = this.app;
    const found = by > 0 ? times.find((t) => t > time + 1e-6) : times.findLast((t) => t < time - 1e-6);
    this.app.seek(found ?? (by > 0 ? this.app.run.end : 0));
  }

  /** To the next moment, or the one before. @param {number} by 1 or -1 */
  moment(by) {
    const { all } = this.app.run.moments;
    const { time } = this.app;
    const found =
      by > 0 ? all.find((each) => each.t > time + 1e-6) : all.findLast((each) => each.t < time - 1e-6);
    if (found) this.app.seek(found.t);
  }
}

/** @type {{keys: string[], names: string, does: string, act: (app: App, player: Player, key: string) => void}[]} */
const KEYS_HELP = [
  { keys: [" ", "k"], names: "Space, k", does: "play, pause", act: (_, player) => player.toggle() },
  { keys: ["ArrowLeft", "ArrowRight"], names: "← →", does: "0.1 s back or forward; with Shift 1 s", act: () => {} },
  { keys: ["["], names: "[", does: "back to the previous start or end of a step", act: (_, player) => player.step(-1) },
  { keys: ["]"], names: "]", does: "forward to the next start or end of a step", act: (_, player) => player.step(1) },
  {
    keys: ["p"],
    names: "p",
    does: "the previous moment: a fault, a death, a heal",
    act: (_, player) => player.moment(-1),
  },
  { keys: ["n"], names: "n", does: "the next moment", act: (_, player) => player.moment(1) },
  { keys: ["Home"], names: "Home", does: "the start", act: (app) => app.seek(0) },
  {
    keys: ["End"],
    names: "End",
    does: "the end; follows a live run",
    act: (app) => app.follow(),
  },
  { keys: ["i"], names: "i", does: "lanes and charts show less of the time, larger", act: (app) => app.span.zoom(2, app.time) },
  { keys: ["o"], names: "o", does: "they show more of it", act: (app) => app.span.zoom(0.5, app.time) },
  { keys: ["w"], names: "w", does: "they show the whole run", act: (app) => app.span.whole() },
  { keys: [",", "."], names: ", .", does: "they move to what is before, after", act: (app, _, key) => app.span.pan(key === "," ? -0.5 : 0.5) },
  { keys: ["-"], names: "−", does: "slower", act: (_, player) => player.faster(-1) },
  { keys: ["+", "="], names: "+", does: "faster", act: (_, player) => player.faster(1) },
  {
    keys: ["1", "2", "3", "4", "5", "6", "7", "8", "9"],
    names: "1 to 9",
    does: "choose a robot; press again to choose none",
    act: chooseByKey,
  },
  { keys: ["0", "Escape"], names: "0, Esc", does: "choose none", act: (app) => app.choose(0, app.focus) },
  {
    keys: ["f"],
    names: "f",
    does: "the whole map",
    act: (app) => (app.panes.forEach((pane) => pane.fit()), app.show()),
  },
  {
    keys: ["r"],
    names: "r",
    does: "the map fits the robots",
    act: (app) => (app.panes.forEach((pane) => pane.fitRobots()), app.show()),
  },
  { keys: ["g"], names: "g", does: "the map follows the chosen robot, or the leader; again: it stays", act: (app) => app.watch() },
  {
    keys: ["x", "X"],
    names: "x",
    does: "says what is on the map: the next robot, obstacle or goal; with Shift the one before",
    act: (app, _, key) => app.panes[app.focus].explore(key === "x" ? 1 : -1),
  },
  { keys: ["l"], names: "l", does: "the legend of the map", act: () => byId("map-legend").click() },
  {
    keys: ["c"],
    names: "c",
    does: "the other run, if there are two",
    act: (app) => app.choose(app.robot, (app.focus + 1) % app.runs.length),
  },
  { keys: ["d"], names: "d", does: "dark, light", act: () => toggleTheme() },
  { keys: ["?", "h"], names: "?, h", does: "this help", act: () => toggleHelp() },
];

/** @param {App} app @param {Player} _ @param {string} key */
function chooseByKey(app, _, key) {
  const robot = Number(key);
  if (app.run.bodies.has(robot)) app.choose(app.robot === robot ? 0 : robot, app.focus);
}

/** @param {App} app @param {Player} player */
function listenToKeys(app, player) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !app.run) return;
    const target = /** @type {HTMLElement} */ (event.target);
    const isField = /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName);
    if (isField || (target.tagName === "BUTTON" && event.key === " ")) return;
    const arrow = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const found = KEYS_HELP.find((each) => each.keys.includes(event.key));
    const help = /** @type {HTMLDialogElement} */ (byId("help"));
    if (!found || (help.open && !found.keys.includes("?"))) return;
    event.preventDefault();
    if (!found.keys.includes("x")) hideTip(); // it is of the time before
    if (arrow) app.seek(app.time + arrow * (event.shiftKey ? 1 : 0.1));
    else found.act(app, player, event.key);
  });
}
