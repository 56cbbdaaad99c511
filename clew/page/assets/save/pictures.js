// What is taken away from the page: the map of a moment as SVG or PNG, and the run as a short film.

const FILM_S_MAX = 15; // a longer run is shown faster
const CAPTION_PX = 24;

/** @param {App} app */
function captionOf(app) {
  const { subject } = app.run;
  return `${subject?.scenario?.name ?? "run"}, seed ${subject?.seed ?? "?"}  ·  t = ${app.time.toFixed(2)} s  ·  ${stepWords(app.run, app.time)}`;
}

/** @param {App} app @param {Blob} blob @param {string} kind */
function hand(app, blob, kind) {
  const { subject } = app.run;
  const name = [subject?.scenario?.name ?? "run", `seed${subject?.seed ?? ""}`, kind === "webm" ? "" : `${app.time.toFixed(2)}s`];
  const link = element("a", { href: URL.createObjectURL(blob), download: `${name.filter(Boolean).join("-")}.${kind}` });
  link.click();
  setTimeout(() => URL.revokeObjectURL(/** @type {HTMLAnchorElement} */ (link).href), 60_000); // the browser may still be writing
}

/** The map in focus, as text. @param {App} app */
function svgOf(app) {
  const { view, run } = app.panes[app.focus];
  const made = new SvgContext(view.width, view.height + CAPTION_PX);
  const context = /** @type {CanvasRenderingContext2D} */ (/** @type {unknown} */ (made));
  drawGround(context, view, run);
  app.panes[app.focus].paint(context, app.time);
  drawCaption(app, context, view.width, view.height);
  return made.text(colour.card);
}

/** @param {App} app @param {CanvasRenderingContext2D} context @param {number} width px @param {number} top px */
function drawCaption(app, context, width, top) {
  context.fillStyle = colour.card;
  context.beginPath();
  for (const [x, y] of [[0, top], [width, top], [width, top + CAPTION_PX], [0, top + CAPTION_PX]]) context.lineTo(x, y);
  context.fill();
  context.fillStyle = colour.ink;
  context.font = font(12);
  context.textAlign = "left";
  context.textBaseline = "middle";
  context.fillText(captionOf(app), 8, top + CAPTION_PX / 2);
}

/** The map in focus as it is now, onto another canvas. @param {App} app @param {HTMLCanvasElement} canvas */
function copyMap(app, canvas) {
  const { view, canvas: map } = app.panes[app.focus];
  const ratio = window.devicePixelRatio || 1;
  const context = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  Object.assign(canvas, canvas.width === map.width ? {} : { width: map.width, height: map.height + CAPTION_PX * ratio });
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = colour.card;
  context.fillRect(0, 0, view.width, view.height + CAPTION_PX);
  context.drawImage(map, 0, 0, view.width, view.height);
  drawCaption(app, context, view.width, view.height);
}

/** @param {App} app @param {string} kind */
async function save(app, kind) {
  if (kind === "svg") return hand(app, new Blob([svgOf(app)], { type: "image/svg+xml" }), kind);
  const canvas = document.createElement("canvas");
  app.draw();
  copyMap(app, canvas);
  if (kind === "png") return canvas.toBlob((blob) => blob && hand(app, blob, kind));
  hand(app, await film(app, canvas), kind);
}

/** The whole run, in FILM_S_MAX at most. @param {App} app @param {HTMLCanvasElement} canvas @returns {Promise<Blob>} */
async function film(app, canvas) {
  const recorder = new MediaRecorder(canvas.captureStream(), { mimeType: "video/webm", videoBitsPerSecond: 4e6 });
  /** @type {Blob[]} */
  const pieces = [];
  recorder.ondataavailable = ({ data }) => pieces.push(data);
  const stopped = new Promise((done) => (recorder.onstop = done));
  const [before, speed] = [app.time, Math.max(app.run.end / FILM_S_MAX, 1)];
  recorder.start();
  const began = performance.now();
  for (let t = 0; t < app.run.end; ) {
    const now = await new Promise((done) => requestAnimationFrame(done));
    t = Math.min((speed * Math.max(now - began, 0)) / 1000, app.run.end);
    app.seek(t);
    app.draw();
    copyMap(app, canvas);
  }
  recorder.stop();
  await stopped;
  app.seek(before);
  return new Blob(pieces, { type: "video/webm" });
}
