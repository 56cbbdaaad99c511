// The page's state: runs, the time shown, what is chosen; and when it is drawn.

const REFRESH_MS = 400; // between two such drawings of a run that goes on, which bring little and take long

class App {
  constructor() {
    /** @type {Run[]} */
    this.runs = [];
    /** @type {Pane[]} */
    this.panes = [];
    this.focus = 0; // the run that the time, the charts and the tables are of
    this.time = 0;
    this.robot = 0; // chosen; 0: none
    this.layers = new Set(LAYERS.map((layer) => layer.id));
    this.news = 0; // counts what was taken in and shown
    this.hasNews = false;
    this.follows = false; // the end of a run that goes on
    this.isWatching = false; // maps keep a robot in their middle
    this.isAwaited = false; // a frame has been asked for
    this.isOpening = false; // more is to be taken in before anything is drawn
    this.refreshed = -Infinity; // when all that is not of one moment was drawn last [ms]
    this.span = new Span(this);
    this.end = 0; // of the run in focus, as it was then: what axes reach to
    this.drawn = 0; // frames
    /** @type {Chart[]} */
    this.charts = [];
    /** @type {Lanes | null} */
    this.lanes = null;
    /** @type {(() => void)[]} */
    this.onTime = [];
  }

  get run() {
    return this.runs[this.focus];
  }

  /** Take a batch of a run in. @param {number} index @param {any} batch */
  take(index, batch) {
    while (this.runs.length <= index) {
      this.runs.push(new Run());
      const pane = new Pane(this, this.panes.length);
      this.panes.push(pane);
      byId("panes").append(pane.figure);
    }
    this.runs[index].take(batch);
    this.hasNews = true;
    if (this.follows && index === this.focus) this.time = this.run.newest;
    this.show();
  }

  /** Draw again all that is not of one moment. */
  refresh() {
    this.news++;
    this.end = this.run.end;
    document.documentElement.style.setProperty("--map", this.run.bodies.size > CROWD ? "210px" : "300px");
    for (const show of [showVerdict, showSteps, showMoments, showMessages, showAsked, showDifferences]) show(this);
    this.refreshed = performance.now();
  }

  /** @param {number} time of the run in focus [s] */
  seek(time) {
    this.follows = false;
    this.time = Math.min(Math.max(time, 0), this.run.end);
    this.span.keep(this.time);
    this.show();
  }

  /** To the end; of a run that goes on, stay there. */
  follow() {
    this.seek(this.run.newest);
    this.follows = !this.run.ended;
  }

  /** @param {number} robot 0: none @param {number} index of its run */
  choose(robot, index) {
    if (index !== this.focus) {
      const time = this.timeOf(index);
      this.focus = index;
      this.time = time;
      this.span.whole();
      this.hasNews = true;
      this.refreshed = -Infinity;
    }
    this.robot = robot;
    this.show();
  }

  /** Begin or end to keep a robot in the middle. */
  watch() {
    this.isWatching = !this.isWatching;
    this.show();
  }

  /** The time at which a run is shown: runs are aligned by their switching steps. @param {number} index */
  timeOf(index) {
    return index === this.focus ? this.time : aligned(this.run, this.runs[index], this.time);
  }

  /** Ask for a frame. */
  show() {
    if (this.isAwaited || this.isOpening) return;
    this.isAwaited = true;
    requestAnimationFrame(() => {
      this.isAwaited = false;
      this.draw();
    });
  }

  draw() {
    if (this.runs.length === 0) return;
    const isFresh = this.hasNews && performance.now() - this.refreshed > REFRESH_MS;
    if (isFresh) this.refresh();
    for (const pane of this.panes) pane.draw();
    for (const chart of this.charts) chart.draw();
    this.lanes?.draw();
    showNow(this);
    showInspector(this);
    markStep(this);
    markMoment(this);
    if (isFresh) this.hasNews = false;
    else if (this.hasNews) setTimeout(() => this.show(), REFRESH_MS);
    this.drawn++;
    for (const tell of this.onTime) tell();
  }
}
