// The chosen robot at the time shown: what it does, its links, its last order, and what it knows.

/** @param {App} app */
function showInspector(app) {
  const { run, robot, time } = app;
  const body = run.bodies.get(robot);
  byId("inspector").hidden = !body;
  if (!body) return;
  body.goTo(time);
  const rows = factsOf(run, body, time).filter(([, said]) => said);
  const text = JSON.stringify([robot, rows]);
  if (inspected === text) return;
  inspected = text;
  byId("inspected").textContent = `Robot ${robot}`;
  byId("inspector-facts").replaceChildren(
    ...rows.flatMap(([name, said]) => [element("dt", {}, name), element("dd", {}, said)]),
  );
}

let inspected = "";

/** @param {Run} run @param {Body} body @param {number} t @returns {[string, string][]} */
function factsOf(run, body, t) {
  const strand = strandAt(run, t);
  const place = strand ? strand.order.indexOf(body.robot) : -1;
  return [
    ["does", `${doingAt(run, body, t)}${place === 0 ? ", leads" : ""}`],
    ["place", `(${body.x.toFixed(2)}, ${body.y.toFixed(2)}) m, ${((body.heading * 180) / Math.PI).toFixed(0)}°, ${metres(body.clearance.at(t), 3)} clear`],
    ["strand", strand && place >= 0 ? `${place + 1} of ${strand.order.length}, epoch ${strand.epoch}, turn ${strand.turn}` : "outside"],
    ["ahead", strand && place > 0 ? neighbourWords(run, body.robot, strand.order[place - 1], t, true) : ""],
    ["behind", strand && place >= 0 && place + 1 < strand.order.length ? neighbourWords(run, body.robot, strand.order[place + 1], t, false) : ""],
    ["last order", orderWords(run, body, t)],
    ["last scan", newestWords(run, "scan.served", body.robot, t, (rows, i) => `${rows.hits[i]} hits`)],
    ["last plan", newestWords(run, "step.planned", body.robot, t, planWords)],
    ["segment", newestWords(run, "segment.checked", body.robot, t, (rows, i) => `${rows.clear[i] ? "clear" : "not clear"}, ${metres(rows.clearance_m[i], 2)}`)],
    ["knows", newestWords(run, "strand.joined", body.robot, t, (rows, i) => `epoch ${rows.epoch[i]}, rank ${rows.rank[i]} of ${rows.members[i]}`)],
  ];
}

/** @param {Columns} rows @param {number} i */
function planWords(rows, i) {
  const degrees = ((rows.heading_rad[i] * 180) / Math.PI).toFixed(0);
  const promised = rows.promised_clearance_m[i] === null ? "" : `, promises ${metres(rows.promised_clearance_m[i], 3)}`;
  const left = rows.cost_to_go_m[i] === null ? "" : `, leaves a cost-to-go of ${metres(rows.cost_to_go_m[i], 2)}`;
  const seen = `${counted(rows.obstacles[i].length, "obstacle")}, ${counted(rows.gaps[i].length, "gap")} seen`;
  return `step ${rows.step[i]}: ${metres(rows.length_m[i], 2)} at ${degrees}°${promised}${left}; ${seen}`;
}

/** @param {Run} run @param {string} kind @param {string | number} key @param {number} t @param {(rows: Columns, i: number) => string} say */
function newestWords(run, kind, key, t, say) {
  const row = run.lookup(kind, key).at(t);
  const rows = run.kind(kind);
  return row < 0 ? "" : `${say(rows, row)}, ${(t - rows.t[row]).toFixed(1)} s ago`;
}

/** @param {Run} run @param {number} robot @param {number} other @param {number} t @param {boolean} isAhead */
function neighbourWords(run, robot, other, t, isAhead) {
  const key = isAhead ? `${other}>${robot}` : `${robot}>${other}`;
  const granted = newestWords(run, "authority.granted", key, t, (rows, i) => `${metres(rows.authority_m[i], 2)} granted`);
  return `r${other}: ${linkWords(run, robot, other, t)}${granted && `; ${granted}`}`;
}

/** @param {Run} run @param {Body} body @param {number} t */
function orderWords(run, body, t) {
  const said = newestWords(run, "order.accepted", body.robot, t, (rows, i) => {
    const [x, y] = rows.target[i];
    return `${rows.number[i]} to (${x.toFixed(2)}, ${y.toFixed(2)}), ${metres(Math.hypot(body.x - x, body.y - y), 2)} left`;
  });
  const refused = newestWords(run, "order.refused", body.robot, t, (rows, i) => `${rows.number[i]} refused`);
  return [said, refused].filter(Boolean).join("; ");
}
