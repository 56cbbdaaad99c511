// What is under the pointer, or where keys have led, in words beside it; and aloud, for screen readers.

const SPEAK_MS = 400; // what changes sooner is not said aloud

let speaking = 0;

/** Say it aloud, if nothing else is to be said soon. @param {string} said */
function speak(said) {
  clearTimeout(speaking);
  speaking = window.setTimeout(() => (byId("spoken").textContent = said), SPEAK_MS);
}

function hideTip() {
  byId("tip").hidden = true;
}

/** @param {string} said empty: nothing @param {number} left of the window [px] @param {number} top */
function showTip(said, left, top) {
  const tip = byId("tip");
  tip.hidden = !said;
  tip.textContent = said;
  const [x, y] = [left + 14, top + 16];
  const isLow = y + tip.offsetHeight > window.innerHeight;
  tip.style.left = `${Math.max(Math.min(x, window.innerWidth - tip.offsetWidth - 4), 4)}px`;
  tip.style.top = `${isLow ? top - tip.offsetHeight - 8 : y}px`;
  speak(said);
}

/** @param {HTMLCanvasElement} canvas @param {(x: number, y: number) => string} say what is there; empty: nothing */
function hovering(canvas, say) {
  canvas.addEventListener("pointermove", (event) => {
    if (event.pointerType === "touch" || event.buttons) return hideTip();
    showTip(say(event.offsetX, event.offsetY), event.clientX, event.clientY);
  });
  for (const each of ["pointerleave", "pointerdown", "blur"]) canvas.addEventListener(each, hideTip);
}

const NEAR_PX = { curve: 14, mark: 4, sign: 7 };

/** @param {Chart} chart @param {number} x @param {number} y */
function sayChart(chart, x, y) {
  const { width, height } = { width: chart.canvas.clientWidth, height: chart.canvas.clientHeight };
  const { app } = chart;
  const t = app.span.timeAt((x - MARGIN.left) / (width - MARGIN.left - MARGIN.right));
  let [said, least] = ["", NEAR_PX.curve];
  for (const { name, key, curve, who } of [...chart.series, ...chart.others]) {
    const value = curve.at(t);
    const far = Math.abs(chart.y(Math.min(value, chart.most), height) - y);
    if (!(far < least) || (app.robot && key && key !== app.robot)) continue;
    const named = who?.(placeAt(curve.t.data, curve.t.length, t)) ?? name;
    [said, least] = [`${named}: ${chart.plot.decimals ? metres(value, chart.plot.decimals) : value}`, far];
  }
  const mark = chart.plot.marks(app.run).find(({ value }) => Math.abs(chart.y(value, height) - y) < NEAR_PX.mark);
  if (mark && least > NEAR_PX.mark) said = `${mark.name}: ${metres(mark.value, 3)}`;
  return `${t.toFixed(2)} s${said && `  ·  ${said}`}`;
}

/** @param {Lanes} lanes @param {number} x @param {number} y */
function sayLanes(lanes, x, y) {
  const { app } = lanes;
  const { run } = app;
  const width = lanes.canvas.clientWidth;
  if (y > lanes.canvas.clientHeight - LANE.axis) return "drag: scrub  ·  Shift and drag: pick a time  ·  Ctrl and wheel: zoom";
  const robot = run.robots[Math.floor((y - lanes.lanesTop) / lanes.laneHeight)];
  if (x < LANE.left) return y > lanes.lanesTop && robot ? `robot ${robot}: click to choose it` : "";
  const t = app.span.timeAt((x - LANE.left) / (width - LANE.left - LANE.right));
  if (y >= lanes.lanesTop) {
    const part = doings(run, robot).findLast(({ from, to }) => from <= t && t <= to);
    const does = part ? (DOES[part.does] ?? part.does) : "not there yet";
    return `robot ${robot}: ${does}${part ? `, ${part.from.toFixed(2)} to ${part.to.toFixed(2)} s` : ""}`;
  }
  if (y < LANE.top + LANE.band) {
    const step = run.steps.findLast(({ from, to }) => from <= t && t <= to);
    return step ? sayStep(step) : "no step is driven";
  }
  const row = y < LANE.top + LANE.band + LANE.signs ? 0 : 1;
  const near = run.moments.all.filter((each) => each.sign.row === row && Math.abs(lanes.x(each.t, width) - x) < NEAR_PX.sign);
  const told = rarestFirst(near).slice(0, 3).map((each) => `${each.t.toFixed(2)} s  ${each.sign.sign} ${each.says}`);
  return [...told, ...(near.length > 3 ? [`and ${near.length - 3} more`] : [])].join("\n");
}

/** What a chart has at the time shown, of the chosen robot or the least. @param {Chart} chart */
function chartNow({ app, series, plot }) {
  const known = series
    .map(({ name, key, curve }) => ({ name, key, value: curve.at(app.time) }))
    .filter(({ key, value }) => !Number.isNaN(value) && (!app.robot || !key || key === app.robot))
    .sort((one, other) => one.value - other.value);
  const told = known.slice(0, 3).map(({ name, value }) => `${name}: ${plot.decimals ? metres(value, plot.decimals) : value}`);
  return [...told, ...(known.length > told.length ? [`${known.length - told.length} more above`] : [])].join(", ") || plot.none(app.run);
}

/** What the lanes have at the time shown. @param {App} app */
function lanesNow({ run, time, robot }) {
  const step = run.steps.findLast(({ from, to }) => from <= time && time <= to);
  const near = run.moments.all.filter((each) => Math.abs(each.t - time) < 0.05).slice(0, 3);
  const all = [...run.bodies.values()].filter((body) => !robot || body.robot === robot);
  /** @type {Map<string, number[]>} */
  const does = new Map();
  for (const body of all) {
    body.goTo(time);
    const said = doingAt(run, body, time);
    does.set(said, [...(does.get(said) ?? []), body.robot]);
  }
  const told = [...does].map(([said, who]) => `${who.length > 6 ? `${who.length} robots` : who.map((each) => `r${each}`).join(", ")} ${said}`);
  return [step ? `step ${step.step}` : "no step", ...told, ...near.map(({ says }) => says)].join("; ");
}

/** @param {Step} step */
function sayStep({ step, from, to, end, row }) {
  const promised = row.promised_m === null ? "" : `, promised ${metres(row.promised_m, 3)}`;
  const kept = row.clearance_m === null ? "" : `, kept ${metres(row.clearance_m, 3)}`;
  return `step ${step} of r${row.robot}: ${from.toFixed(2)} to ${to.toFixed(2)} s, ${metres(row.length_m, 3)}${promised}${kept}, ${end || "under way"}`;
}
