// The pointer on what has time from left to right: it scrubs, picks a part of the time, zooms and pans.

/** @typedef {{left: number, right: number}} Sides what of a canvas is beside its time [px] */

/** @param {HTMLCanvasElement} canvas @param {App} app @param {Sides} sides */
function scrubbing(canvas, app, { left, right }) {
  const timeAt = (/** @type {MouseEvent} */ event) =>
    app.span.timeAt((event.offsetX - left) / (canvas.clientWidth - left - right));
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "slider"); // the arrow keys move its time
  canvas.addEventListener("focus", () => app.show());
  let began = 0;
  const drag = (/** @type {PointerEvent} */ event) => {
    const t = timeAt(event);
    if (app.span.picked) app.span.picked = { from: Math.min(began, t), to: Math.max(began, t) };
    else app.seek(t);
    app.show();
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    began = timeAt(event);
    app.span.picked = event.shiftKey ? { from: began, to: began } : null;
    drag(event);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (canvas.hasPointerCapture(event.pointerId)) drag(event);
  });
  const lift = () => {
    const { picked } = app.span;
    app.span.picked = null;
    if (picked && picked.to > picked.from) app.span.show(picked.from, picked.to);
    app.show();
  };
  canvas.addEventListener("pointerup", lift);
  canvas.addEventListener("pointercancel", lift);
  canvas.addEventListener("dblclick", () => app.span.whole());
  canvas.addEventListener(
    "wheel",
    (event) => {
      const across = event.shiftKey ? event.deltaX || event.deltaY : event.deltaX;
      if (event.ctrlKey || event.altKey) app.span.zoom(Math.exp(-event.deltaY / 300), timeAt(event));
      else if (Math.abs(across) > Math.abs(event.shiftKey ? 0 : event.deltaY)) app.span.pan(across / 800);
      else return; // the page scrolls
      event.preventDefault();
    },
    { passive: false },
  );
}

/** Tell a screen reader the time, and in words what there is then. @param {HTMLCanvasElement} canvas @param {App} app @param {() => string} say */
function tellTime(canvas, app, say) {
  canvas.setAttribute("aria-valuemin", "0");
  canvas.setAttribute("aria-valuemax", app.end.toFixed(2));
  canvas.setAttribute("aria-valuenow", app.time.toFixed(2));
  const said = document.activeElement === canvas ? `: ${say()}` : ""; // nobody hears the others
  canvas.setAttribute("aria-valuetext", `${app.time.toFixed(2)} seconds of ${app.end.toFixed(2)}${said}`);
}

/** Time's marks over a picture: where it is now, and what is being picked. @param {App} app @param {CanvasRenderingContext2D} context @param {(t: number) => number} x @param {number} top px @param {number} bottom px */
function drawTime(app, context, x, top, bottom) {
  const { picked } = app.span;
  if (picked) {
    context.globalAlpha = 0.2;
    context.fillStyle = colour.promise;
    context.fillRect(x(picked.from), top, x(picked.to) - x(picked.from), bottom - top);
    context.globalAlpha = 1;
  }
  const share = app.span.share(app.time);
  if (share < 0 || share > 1) return;
  context.strokeStyle = colour.ink;
  context.beginPath();
  context.moveTo(x(app.time), top);
  context.lineTo(x(app.time), bottom);
  context.stroke();
}
