// One map: a run from above, to look at, to move about in, and to choose a robot on.

class Pane {
  /** @param {App} app @param {number} index of its run */
  constructor(app, index) {
    this.app = app;
    this.index = index;
    this.view = new View();
    this.ground = new Still();
    this.fitted = 0; // what the app had refreshed then
    this.explored = -1; // the thing that keys have led to; -1: none yet
    this.figure = document.createElement("figure");
    this.figure.className = "pane";
    this.canvas = document.createElement("canvas");
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "img");
    this.caption = document.createElement("figcaption");
    this.figure.append(this.canvas, this.caption);
    this.listen();
  }

  get run() {
    return this.app.runs[this.index];
  }

  draw() {
    const { context, width, height } = surfaceOf(this.canvas);
    const { run, view, app } = this;
    if (width === 0) return;
    const hasResized = view.width !== width || view.height !== height;
    Object.assign(view, { width, height });
    if (view.isFitted && (hasResized || app.refreshed !== this.fitted)) this.fit();
    const t = app.timeOf(this.index);
    if (app.isWatching) this.watch(t);
    context.clearRect(0, 0, width, height);
    const key = `${view.scale}|${view.x}|${view.y}|${run.subject?.run}`;
    this.ground.show(context, width, height, key, (onto) => drawGround(onto, view, run));
    this.paint(context, t);
    this.say(t);
  }

  /** All that changes with time. @param {CanvasRenderingContext2D} context @param {number} t */
  paint(context, t) {
    const { run, view, app } = this;
    run.goTo(t);
    drawMovers(context, view, run, t);
    context.save();
    view.apply(context);
    const strand = strandAt(run, t);
    const robot = app.focus === this.index ? app.robot : 0;
    const leader = strand?.order[0] || Math.min(...run.robots, Infinity);
    const sees = robot || leader;
    const plans = run.lookup("step.planned", sees).at(t) >= 0 ? sees : leader;
    /** @type {Scene} */
    const scene = { context, view, run, t, px: 1 / view.scale, robot, sees, plans, strand };
    for (const layer of LAYERS) if (app.layers.has(layer.id)) layer.draw(scene);
    drawRobots(scene);
    context.restore();
  }

  /** @param {number} t */
  say(t) {
    const { run, app } = this;
    const several = app.runs.length > 1;
    this.caption.hidden = !several;
    if (several) {
      const word = run.verdict ? (run.verdict.ok ? "✓" : "✗") : "";
      this.caption.textContent = `${"ABCDEFGH"[this.index]}  ${run.subject?.folder || run.subject?.run || ""}  ${word}  t = ${t.toFixed(2)} s, ${stepWords(run, t)}`;
      this.figure.classList.toggle("chosen", app.focus === this.index);
    }
    const name = `Map of run ${run.subject?.run ?? ""}: ${run.bodies.size} robots; x says what is on it, one thing after the other`;
    if (this.canvas.getAttribute("aria-label") !== name) this.canvas.setAttribute("aria-label", name);
  }

  listen() {
    /** @type {Map<number, {x: number, y: number}>} */
    const fingers = new Map();
    let moved = 0;
    const { canvas, view, app } = this;
    hovering(canvas, (x, y) => sayMap(this, x, y));
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, { x: event.offsetX, y: event.offsetY });
      moved = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      const now = { x: event.offsetX, y: event.offsetY };
      const other = [...fingers.entries()].find(([id]) => id !== event.pointerId)?.[1];
      if (other) {
        const spread =
          Math.hypot(now.x - other.x, now.y - other.y) /
          Math.max(Math.hypot(before.x - other.x, before.y - other.y), 1);
        view.zoom(spread, (now.x + other.x) / 2, (now.y + other.y) / 2);
      }
      app.isWatching = false;
      view.pan((now.x - before.x) / fingers.size, (now.y - before.y) / fingers.size);
      moved += Math.hypot(now.x - before.x, now.y - before.y);
      fingers.set(event.pointerId, now);
      app.show();
    });
    const lift = (/** @type {PointerEvent} */ event) => {
      if (fingers.delete(event.pointerId) && moved < 5 && event.type === "pointerup")
        app.choose(this.robotAt(event.offsetX, event.offsetY, 16), this.index);
    };
    canvas.addEventListener("pointerup", lift);
    canvas.addEventListener("pointercancel", lift);
    canvas.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        view.zoom(Math.exp(-event.deltaY / 400), event.offsetX, event.offsetY);
        app.show();
      },
      { passive: false },
    );
    canvas.addEventListener("dblclick", () => {
      this.fit();
      app.show();
    });
  }

  /** Have the whole run in view, and keep it so. */
  fit() {
    this.view.isFitted = true;
    this.app.isWatching = false;
    this.fitted = this.app.refreshed;
    const box = boxOfAll(this.app.runs); // the same for all: what is to be compared is drawn to one scale
    const aspect = (box.top - box.bottom) / (box.right - box.left) / this.app.runs.length;
    byId("panes").style.setProperty("--aspect", String(aspect));
    this.view.fit(box);
  }

  /** Have all robots in view, as large as that lets them be. */
  fitRobots() {
    const t = this.app.timeOf(this.index);
    const box = { left: Infinity, right: -Infinity, bottom: Infinity, top: -Infinity };
    for (const body of this.run.bodies.values()) {
      body.goTo(t);
      if (!Number.isNaN(body.x)) widen(box, body.x, body.y, 4 * this.run.radius + this.run.epsilon);
    }
    if (!(box.left < box.right)) return;
    this.view.fit(box);
    this.view.isFitted = false;
    this.app.isWatching = false;
  }

  /** Have the chosen robot, or the leader, in the middle. @param {number} t */
  watch(t) {
    const { app, run, view } = this;
    const body = run.bodies.get((app.focus === this.index && app.robot) || strandAt(run, t)?.order[0] || 0);
    body?.goTo(t);
    if (!body || Number.isNaN(body.x)) return;
    Object.assign(view, { x: body.x, y: body.y, isFitted: false });
  }

  /** Go on to the next thing on the map, or back, and say what it is. @param {number} by 1 or -1 */
  explore(by) {
    const { run, view, canvas } = this;
    const t = this.app.timeOf(this.index);
    run.goTo(t);
    const places = [
      ...run.robots.map((robot) => run.body(robot)).filter(({ x }) => !Number.isNaN(x)),
      ...run.scenario.obstacle.map(middleOf),
      ...(run.scenario.goal ? [{ x: run.scenario.goal.at_m[0], y: run.scenario.goal.at_m[1] }] : []),
    ];
    this.explored = (this.explored + by + places.length) % places.length;
    const [x, y] = view.toScreen(places[this.explored].x, places[this.explored].y);
    const { left, top } = canvas.getBoundingClientRect();
    showTip(sayMap(this, x, y), left + x, top + y);
  }

  /** The robot there; 0: none. @param {number} px @param {number} py @param {number} [around] px */
  robotAt(px, py, around = 8) {
    const reach = Math.max(this.run.radius * this.view.scale, around);
    let [nearest, least] = [0, reach];
    for (const body of this.run.bodies.values()) {
      const [x, y] = this.view.toScreen(body.x, body.y);
      const far = Math.hypot(px - x, py - y);
      if (far < least) [nearest, least] = [body.robot, far];
    }
    return nearest;
  }
}
