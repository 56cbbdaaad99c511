// The page begins here: what there is to show is opened, and hooks are set for those who feed or test it.

const app = new App();
const player = new Player(app);

/** Whether the runs inlined in the page have been opened; a page without any is fed. */
const opened = begin().catch((error) => {
  byId("badge").textContent = "✗ The run cannot be shown";
  byId("reason").textContent = String(error);
  throw error;
});

async function begin() {
  readTheme();
  app.charts = PLOTS.map((plot) => new Chart(app, plot, byId("charts")));
  app.lanes = new Lanes(app, /** @type {HTMLCanvasElement} */ (byId("lanes")));
  listenToControls(app, player);
  listenToKeys(app, player);
  retheme(app);
  const story = byId("story").textContent ?? "";
  if (story) {
    await openStory(story);
    const [first] = app.runs;
    app.time = first?.verdict || first?.ended ? 0 : (first?.end ?? 0);
  } else {
    app.follows = true;
  }
  followAddress(app);
  window.addEventListener("hashchange", () => followAddress(app));
  keepAddress(app, player);
  app.show();
}

/** Lines of `[run_index, batch]`, packed by gzip and base64. @param {string} story */
async function openStory(story) {
  const packed = Uint8Array.from(atob(story), (letter) => letter.charCodeAt(0));
  const lines = new Blob([packed])
    .stream()
    .pipeThrough(new DecompressionStream("gzip"))
    .pipeThrough(new TextDecoderStream());
  let rest = "";
  app.isOpening = true;
  const reader = lines.getReader();
  for (let piece = await reader.read(); !piece.done; piece = await reader.read()) {
    const parts = (rest + piece.value).split("\n");
    rest = parts.pop() ?? "";
    for (const line of parts) {
      const [index, batch] = JSON.parse(line);
      app.take(index, batch);
    }
  }
  app.isOpening = false;
}

/** For feeds, which call `take`, and for tests. */
window.clew = {
  take: (/** @type {number} */ index, /** @type {any} */ batch) => app.take(index, batch),
  seek: (/** @type {number} */ time) => app.seek(time),
  choose: (/** @type {number} */ robot) => app.choose(robot, app.focus),
  draw: () => app.draw(),
  opened,
  get time() {
    return app.time;
  },
  get robot() {
    return app.robot;
  },
  get runs() {
    return app.runs;
  },
  get panes() {
    return app.panes;
  },
  get charts() {
    return app.charts;
  },
  get lanes() {
    return app.lanes;
  },
  get span() {
    return app.span;
  },
  get frames() {
    return app.drawn;
  },
  /** Where the robots of a run are now, and what they do. @param {number} index */
  frame: (index = 0) =>
    [...app.runs[index].bodies.values()].map((body) => {
      body.goTo(app.timeOf(index));
      return {
        robot: body.robot,
        x: body.x,
        y: body.y,
        heading: body.heading,
        does: doingAt(app.runs[index], body, app.timeOf(index)),
      };
    }),
};
