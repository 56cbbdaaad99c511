// How the strand was at a time: its order, its links, its path, and how far its robots may drive.

/** The strand that had formed by then. @param {Run} run @param {number} t */
function strandAt(run, t) {
  let place = run.strands.length - 1;
  while (place >= 0 && run.strands[place].t_s > t) place--;
  return place < 0 ? null : run.strands[place];
}

/** @param {Run} run @param {number} one @param {number} other @param {number} t */
function linkAt(run, one, other, t) {
  return stateAt(run.links.get(`${Math.min(one, other)}-${Math.max(one, other)}`), t);
}

/** A link's state, and for how long it has had it. @param {Run} run @param {number} one @param {number} other @param {number} t */
function linkWords(run, one, other, t) {
  const changes = run.links.get(`${Math.min(one, other)}-${Math.max(one, other)}`);
  const place = changes ? placeAt(changes.t, changes.t.length, t) : -1;
  if (!changes || place < 0) return "up";
  return `${changes.state[place]} for ${(t - changes.t[place]).toFixed(1)} s`;
}

/**
 * How far a robot is along the strand's path [m]: of its order's target, less what is left to drive.
 * @param {Run} run @param {Body} body @param {{epoch: number, turn: number}} strand @param {number} t
 * @param {number} x where it is then @param {number} y
 */
function progressAt(run, body, strand, t, x, y) {
  const row = run.lookup("order.accepted", body.robot).at(t);
  const orders = run.kind("order.accepted");
  if (row < 0 || orders.epoch[row] !== strand.epoch || orders.turn[row] !== strand.turn) return NaN;
  const target = orders.target[row];
  return orders.reach_m[row] - Math.hypot(target[0] - x, target[1] - y);
}

/**
 * The movement authority of a robot [m along the strand's path]; NaN: nobody has granted it any.
 * @param {Run} run @param {{epoch: number, order: number[]}} strand @param {number} place its place in the order
 * @param {number} t
 */
function authorityAt(run, strand, place, t) {
  if (place === 0) return NaN;
  const row = run.lookup("authority.granted", `${strand.order[place - 1]}>${strand.order[place]}`).at(t);
  const grants = run.kind("authority.granted");
  return row < 0 || grants.epoch[row] !== strand.epoch ? NaN : grants.authority_m[row];
}

/** Whether the fence lets a robot drive by this plan. @param {Run} run @param {number} robot @param {number} row @param {number} t */
function isObeyed(run, robot, row, t) {
  const [steps, fences] = [run.kind("step.planned"), run.kind("fence.changed")];
  const newest = placeAt(fences.t ?? [], (fences.t ?? []).length, t);
  if (newest < 0 || fences.epoch[newest] !== steps.epoch[row]) return false;
  if (!steps.joins[row]) return fences.may[newest] === "all";
  return fences.may[newest] === "one" && fences.named[newest] === robot;
}

/**
 * The part of a path between two arc lengths, for a canvas.
 * @param {CanvasRenderingContext2D} context @param {{x: number, y: number, s: number}[]} path
 * @param {number} from @param {number} to
 */
function tracePath(context, path, from, to) {
  if (!(to > from) || path.length < 2) return;
  context.beginPath();
  let isBegun = false;
  for (let i = 1; i < path.length; i++) {
    const [start, end] = [path[i - 1], path[i]];
    if (end.s < from || start.s > to || end.s === start.s) continue;
    if (!isBegun) context.moveTo(...along(start, end, Math.max(from, start.s)));
    isBegun = true;
    context.lineTo(...along(start, end, Math.min(to, end.s)));
  }
}

/**
 * @param {{x: number, y: number, s: number}} start @param {{x: number, y: number, s: number}} end @param {number} s
 * @returns {[number, number]}
 */
function along(start, end, s) {
  const share = (s - start.s) / (end.s - start.s);
  return [start.x + share * (end.x - start.x), start.y + share * (end.y - start.y)];
}

/** @param {{x: number, y: number, s: number}[]} path @param {number} s @returns {[number, number]} */
function pointAt(path, s) {
  for (let i = 1; i < path.length; i++) {
    if (path[i].s >= s && path[i].s > path[i - 1].s)
      return along(path[i - 1], path[i], Math.max(s, path[i - 1].s));
  }
  const last = path[path.length - 1];
  return [last.x, last.y];
}
