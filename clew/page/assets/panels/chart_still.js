// What of a chart does not change as time is scrubbed: its axes, its marks and its curves.

/** @param {Chart} chart @param {CanvasRenderingContext2D} context @param {number} width @param {number} height */
function drawStill(chart, context, width, height) {
  drawTimeAxis(context, chart.app.span, MARGIN.left, width - MARGIN.right, height - MARGIN.bottom);
  drawHeights(chart, context, width, height);
  for (const mark of chart.plot.marks(chart.app.run)) drawMark(chart, context, width, height, mark); // below curves
  const chosen = chart.app.robot;
  context.save();
  context.beginPath();
  context.rect(
    MARGIN.left,
    MARGIN.top - 2,
    width - MARGIN.left - MARGIN.right + 1,
    height - MARGIN.top - MARGIN.bottom + 4,
  );
  context.clip();
  for (const each of chart.others)
    if (!chosen || !each.key || each.key === chosen) drawCurve(chart, context, width, height, each, false);
  for (const each of chart.series)
    if (each.key !== chosen) drawCurve(chart, context, width, height, each, each.key !== 0 && (chosen !== 0 || chart.series.length > CROWD));
  for (const each of chart.series)
    if (each.key === chosen) drawCurve(chart, context, width, height, each, false);
  context.restore();
  nameCurves(chart, context, width, height);
  if (chart.isCut) markCuts(chart, context, width);
}

const CUT_PX = 26; // between two signs that a curve goes on above the top

/** Where curves leave by the top, and where they come back. @param {Chart} chart @param {CanvasRenderingContext2D} context @param {number} width */
function markCuts(chart, context, width) {
  context.font = font(9);
  context.textAlign = "center";
  context.textBaseline = "top";
  let at = -CUT_PX;
  for (const { key, curve } of chart.series) {
    context.fillStyle = colourOf(key);
    if (chart.series.length <= CROWD) at = -CUT_PX;
    for (let i = 0; i < curve.value.length; i++) {
      const x = chart.x(curve.t.data[i], width);
      if (curve.value.data[i] <= chart.most || x - at < CUT_PX || x < MARGIN.left || x > width - MARGIN.right) continue;
      context.fillText("▴", (at = x), MARGIN.top - 8);
    }
  }
}

/** @param {Chart} chart @param {CanvasRenderingContext2D} context @param {number} width @param {number} height */
function drawHeights(chart, context, width, height) {
  const step = roundStep(chart.most, 4);
  context.font = font(11);
  context.textAlign = "right";
  context.textBaseline = "middle";
  context.lineWidth = 1;
  for (let value = 0; value <= chart.most * 1.0001; value += step) {
    const y = Math.round(chart.y(value, height)) + 0.5;
    context.strokeStyle = colour.rule;
    context.beginPath();
    context.moveTo(MARGIN.left, y);
    context.lineTo(width - MARGIN.right, y);
    context.stroke();
    context.fillStyle = colour.soft;
    context.fillText(
      step >= 1 ? String(Math.round(value)) : value.toFixed(step < 0.1 ? 2 : 1),
      MARGIN.left - 6,
      y,
    );
  }
}

/** @param {Chart} chart @param {CanvasRenderingContext2D} context @param {number} width @param {number} height @param {Series} series @param {boolean} isFaint */
function drawCurve(chart, context, width, height, series, isFaint) {
  const { curve } = series;
  context.strokeStyle = colourOf(series.key);
  context.globalAlpha = isFaint ? 0.25 : series.isOther ? 0.6 : 1;
  context.lineWidth = series.key === chart.app.robot ? 2.25 : 1.4;
  context.setLineDash(series.isOther ? [1, 3] : dashOf(series.key));
  context.lineJoin = "round";
  context.beginPath();
  let lowest = Infinity; // of the samples on one pixel only the lowest is drawn, which must not be lost
  let at = -Infinity;
  let before = 0;
  const { from, to } = chart.app.span; // and one place beyond on either side, to which the curve goes on
  const first = Math.max(placeAt(curve.t.data, curve.t.length, from), 0);
  const last = Math.min(placeAt(curve.t.data, curve.t.length, to) + 1, curve.value.length - 1);
  for (let i = first; i <= last; i++) {
    const x = Math.round(chart.x(curve.t.data[i], width) * 2) / 2;
    const value = curve.value.data[i];
    if (x !== at && at > -Infinity) {
      if (series.steps) context.lineTo(at, chart.y(before, height));
      context.lineTo(at, chart.y(lowest, height));
      before = lowest;
      lowest = Infinity;
    }
    at = x;
    lowest = series.steps ? value : Math.min(lowest, value);
  }
  if (at > -Infinity) {
    if (series.steps) context.lineTo(at, chart.y(before, height));
    context.lineTo(at, chart.y(lowest, height));
  }
  context.stroke();
  context.setLineDash([]);
  context.globalAlpha = 1;
}

const NAME_PX = 11; // between the names of two curves: more names than fit are not written

/** Each curve's name at its end, as near to it as the others let it. @param {Chart} chart @param {CanvasRenderingContext2D} context @param {number} width @param {number} height */
function nameCurves(chart, context, width, height) {
  const names = chart.series.map(({ name, key, curve }) => ({
    name,
    key,
    y: chart.y(Math.min(curve.at(chart.app.span.to), chart.most), height),
  })).filter(({ y }) => !Number.isNaN(y));
  names.sort((one, other) => one.y - other.y);
  const bottom = height - MARGIN.bottom;
  if (names.length < 2 || names.length * NAME_PX > bottom) return;
  names.forEach((each, i) => (each.y = Math.max(each.y, i ? names[i - 1].y + NAME_PX : MARGIN.top)));
  for (let i = names.length - 1; i >= 0; i--) {
    names[i].y = Math.min(names[i].y, i + 1 < names.length ? names[i + 1].y - NAME_PX : bottom);
  }
  context.font = font(10.5, "600");
  context.textAlign = "left";
  context.textBaseline = "middle";
  for (const { name, key, y } of names) {
    context.fillStyle = colourOf(key);
    context.fillText(name.length > 5 ? name.slice(0, 5) : name, width - MARGIN.right + 4, y);
  }
}

/** @param {Chart} chart @param {CanvasRenderingContext2D} context @param {number} width @param {number} height @param {Mark} mark */
function drawMark(chart, context, width, height, mark) {
  if (!(mark.value > 0) || mark.value > chart.most) return;
  const y = chart.y(mark.value, height);
  context.strokeStyle = colour.bad;
  context.lineWidth = 1.25;
  context.setLineDash(mark.dash);
  context.beginPath();
  context.moveTo(MARGIN.left, y);
  context.lineTo(width - MARGIN.right, y);
  context.stroke();
  context.setLineDash([]);
  const isBelow = mark.name === "ε − μ0"; // which is too near to ε for both to be on one side
  label(context, width - MARGIN.right - 24, y + (isBelow ? 8 : -8), mark.name, colour.bad);
}

/** @param {CanvasRenderingContext2D} context @param {Span} span @param {number} left px @param {number} right px @param {number} y px */
function drawTimeAxis(context, span, left, right, y) {
  const step = roundStep(span.to - span.from, (right - left) / 70);
  context.strokeStyle = colour.faint;
  context.fillStyle = colour.soft;
  context.font = font(11);
  context.textAlign = "center";
  context.textBaseline = "top";
  context.lineWidth = 1;
  context.beginPath();
  context.moveTo(left, y + 0.5);
  context.lineTo(right, y + 0.5);
  for (let i = Math.ceil(span.from / step - 1e-6); i * step <= span.to * 1.0001; i++) {
    const x = Math.round(left + span.share(i * step) * (right - left)) + 0.5;
    context.moveTo(x, y);
    context.lineTo(x, y + 4);
    context.fillText(step >= 1 ? `${Math.round(i * step)}` : (i * step).toFixed(step < 0.1 ? 2 : 1), x, y + 6);
  }
  context.stroke();
  if (span.isWhole) return;
  context.fillStyle = colour.promise; // how much of the run that is
  const at = (/** @type {number} */ t) => left + (t / span.app.end) * (right - left);
  context.fillRect(at(span.from), y - 1, Math.max(at(span.to) - at(span.from), 3), 3);
}
