// Robots on a map: their hulls with numbers, and the halos that nothing may come into.

/** @param {Scene} scene */
function drawHalos({ context, run, px }) {
  context.lineWidth = px;
  context.setLineDash([3 * px, 2.5 * px]);
  for (const body of run.bodies.values()) {
    context.strokeStyle = colourOf(body.robot);
    circle(context, body.x, body.y, run.radius + run.epsilon);
  }
  context.setLineDash([]);
}

/** Robots, over all else: a disc with its number and a tick ahead; the leader has a second ring, the dead a cross. @param {Scene} scene */
function drawRobots({ context, view, run, t, px, robot, strand }) {
  const radius = Math.max(run.radius, 4 * px); // a point would not be seen
  for (const body of run.bodies.values()) {
    if (Number.isNaN(body.x)) continue;
    const isDead = stateAt(run.lanes.get(body.robot), t) === "dead";
    context.fillStyle = isDead ? colour.card : colourOf(body.robot);
    context.strokeStyle = isDead ? colour.bad : colour.card;
    context.lineWidth = (isDead ? 2 : 1) * px;
    context.beginPath();
    context.arc(body.x, body.y, radius, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
    context.strokeStyle = isDead ? colour.bad : colourOf(body.robot);
    context.lineWidth = 2.5 * px;
    const [cos, sin] = [Math.cos(body.heading), Math.sin(body.heading)];
    stroke(
      context,
      [body.x + radius * cos, body.y + radius * sin],
      [body.x + 1.45 * radius * cos, body.y + 1.45 * radius * sin],
    );
    context.lineWidth = 1.5 * px;
    if (strand?.order[0] === body.robot) circle(context, body.x, body.y, radius + 3 * px);
    if (robot === body.robot) {
      context.strokeStyle = colour.ink;
      circle(context, body.x, body.y, radius + 6 * px);
    }
    if (isDead)
      for (const side of [-1, 1])
        stroke(
          context,
          [body.x - 0.7 * radius, body.y - 0.7 * side * radius],
          [body.x + 0.7 * radius, body.y + 0.7 * side * radius],
        );
  }
  numberRobots(context, view, run, t, radius, [robot, strand?.order[0] ?? 0]);
}

/** Numbers that do not lie on each other, the most wanted first. @param {CanvasRenderingContext2D} context @param {View} view @param {Run} run @param {number} t @param {number} radius @param {number[]} first */
function numberRobots(context, view, run, t, radius, first) {
  const rank = (/** @type {Body} */ { robot }) => (first.includes(robot) ? first.indexOf(robot) : first.length);
  /** @type {[number, number][]} */
  const taken = [];
  for (const body of [...run.bodies.values()].sort((one, other) => rank(one) - rank(other))) {
    const [x, y] = view.toScreen(body.x, body.y);
    if (Number.isNaN(x) || taken.some(([px, py]) => Math.abs(px - x) < NUMBER_PX.wide && Math.abs(py - y) < NUMBER_PX.high)) continue;
    if (radius * view.scale < 9) taken.push([x, y]); // else it stands on the robot itself
    numberRobot(context, view, body, radius, stateAt(run.lanes.get(body.robot), t) === "dead");
  }
}

const NUMBER_PX = { wide: 17, high: 13 }; // of a number of two figures

/** @param {CanvasRenderingContext2D} context @param {View} view @param {Body} body @param {number} radius @param {boolean} isDead */
function numberRobot(context, view, body, radius, isDead) {
  const reach = radius * view.scale;
  onScreen(context, () => {
    const [x, y] = view.toScreen(body.x, body.y);
    if (reach < 9 || isDead) {
      label(
        context,
        x + reach + 9,
        y - reach - 3,
        String(body.robot),
        isDead ? colour.bad : colourOf(body.robot),
      );
      return;
    }
    context.font = font(Math.min(reach * 1.05, 15), "700");
    context.textAlign = "center";
    context.textBaseline = "middle";
    context.fillStyle = colour.card;
    context.fillText(String(body.robot), x, y + 0.5);
  });
}
