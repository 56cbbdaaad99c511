// What a robot did, as pieces of its lane, and how each is drawn; and the signs above the lanes.

/** @param {Run} run @param {number} robot @returns {{from: number, to: number, does: string}[]} */
function doings(run, robot) {
  /** @type {{from: number, to: number, does: string}[]} */
  const parts = [];
  const states = run.lanes.get(robot) ?? { t: [0], state: ["free"] };
  for (let i = 0; i < states.t.length; i++) {
    const [from, to] = [states.t[i], states.t[i + 1] ?? run.end];
    if (to > from) parts.push({ from, to, does: states.state[i] === "free" ? "standing" : states.state[i] });
  }
  const body = run.body(robot);
  for (let i = 0; i + 1 < body.t.length; i++) {
    if (!body.movesFrom(i)) continue;
    const last = parts[parts.length - 1];
    const [from, to] = [body.t.data[i], body.t.data[i + 1]];
    if (last?.does === "driving" && from - last.to < 0.05) last.to = to;
    else parts.push({ from, to, does: "driving" });
  }
  return parts; // driving lies over the rest: a body still rolls when its robot is dead
}

/** What a robot does at a time. @param {Run} run @param {Body} body where it is then @param {number} t */
function doingAt(run, body, t) {
  const state = stateAt(run.lanes.get(body.robot), t) || "free";
  if (body.isMoving) return state === "dead" ? "rolling out, dead" : "driving";
  return DOES[state] ?? state;
}

/** States in words. @type {Record<string, string>} */
const DOES = {
  free: "standing",
  waiting: "waiting for a link",
  holding: "holding for the robot behind",
  aside: "aside, left out of the strand",
};

/**
 * @param {CanvasRenderingContext2D} context @param {string} does @param {number} x @param {number} width
 * @param {number} y @param {number} height @param {string} tone the robot's
 */
function drawDoing(context, does, x, width, y, height, tone) {
  const middle = y + height / 2;
  context.fillStyle = context.strokeStyle = tone;
  context.lineWidth = 1;
  if (does === "driving") context.fillRect(x, y, width, height);
  else if (does === "standing") context.fillRect(x, middle - 1, width, 2);
  else if (does === "arrived") dotted(context, x, width, middle, 1.5, 6, 1.5);
  else if (does === "dead") {
    context.strokeStyle = colour.bad;
    dotted(context, x, width, middle, 0, 0, 0);
    context.beginPath();
    for (let at = x + 4; at < x + width - 2; at += 10) {
      context.moveTo(at - 3, middle - 3);
      context.lineTo(at + 3, middle + 3);
      context.moveTo(at - 3, middle + 3);
      context.lineTo(at + 3, middle - 3);
    }
    context.stroke();
  } else if (does === "aside") dotted(context, x, width, middle, 8, 14, 2);
  else if (does === "waiting") dotted(context, x, width, middle, 3, 5, height * 0.6);
  else if (does === "holding") hatched(context, x, width, y, height);
  else context.strokeRect(x + 0.5, y + 2.5, Math.max(width - 1, 1), height - 5); // lining up
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} width @param {number} y @param {number} dot @param {number} every @param {number} thick */
function dotted(context, x, width, y, dot, every, thick) {
  context.save();
  context.lineWidth = thick || 1;
  if (every) context.setLineDash([dot, every - dot]);
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x + width, y);
  context.stroke();
  context.restore();
}

/** @param {CanvasRenderingContext2D} context @param {number} x @param {number} width @param {number} y @param {number} height */
function hatched(context, x, width, y, height) {
  context.save();
  context.beginPath();
  context.rect(x, y, width, height);
  context.clip();
  context.beginPath();
  for (let at = x - height; at < x + width; at += 4) {
    context.moveTo(at, y + height);
    context.lineTo(at + height, y);
  }
  context.stroke();
  context.strokeRect(x + 0.5, y + 0.5, Math.max(width - 1, 1), height - 1);
  context.restore();
}

const SIGN_PX = 9;

/** Signs of moments. Where many meet, the rarest kind is seen: a death among a hundred silent links. @param {Lanes} lanes @param {CanvasRenderingContext2D} context @param {number} width */
function drawSigns(lanes, context, width) {
  const top = LANE.top + LANE.band;
  context.textBaseline = "middle";
  context.textAlign = "center";
  context.font = font(13, "700");
  /** @type {Set<string>} where one stands */
  const taken = new Set();
  for (const { t, sign } of rarestFirst(lanes.app.run.moments.all)) {
    if (sign.row > 1) continue;
    const x = lanes.x(t, width);
    const place = Math.round(x / SIGN_PX);
    if (taken.has(`${sign.row}/${place}`)) continue;
    taken.add(`${sign.row}/${place}`);
    context.fillStyle = sign.row === 0 ? colour.bad : colour.good;
    context.fillText(sign.sign, x, top + (sign.row + 0.5) * LANE.signs);
  }
}

/** @param {Moment[]} moments @returns {Moment[]} broken promises before all */
function rarestFirst(moments) {
  /** @type {Map<string, number>} */
  const counts = new Map([["promise.broken", -Infinity]]);
  for (const { kind } of moments) counts.set(kind, (counts.get(kind) ?? 0) + 1);
  return [...moments].sort((one, other) => (counts.get(one.kind) ?? 0) - (counts.get(other.kind) ?? 0));
}
