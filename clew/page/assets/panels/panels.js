// What the page says in words: the verdict, what is wrong with the log, and how things are now.

/** @param {string} id @returns {HTMLElement} */
function byId(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`the page has no #${id}`);
  return found;
}

/**
 * An element with what is in it; text is never read as markup.
 * @param {string} tag @param {Record<string, string>} attributes @param {(Node | string)[]} children
 */
function element(tag, attributes, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/** @param {number | null | undefined} value @param {number} decimals */
function metres(value, decimals = 4) {
  return value === null || value === undefined || Number.isNaN(value) ? "–" : `${value.toFixed(decimals)} m`;
}

/** @param {App} app */
function showVerdict(app) {
  const { run } = app;
  const { verdict, subject } = run;
  const word = verdict
    ? verdict.ok
      ? subject?.clearance_m_required === 0
        ? "OK, clearance not promised"
        : "Kept its promises"
      : "Failed"
    : run.ended
      ? "No verdict"
      : "Under way";
  const badge = byId("badge");
  badge.textContent = `${verdict ? (verdict.ok ? "✓ " : "✗ ") : "… "}${word}`;
  badge.className = verdict ? (verdict.ok ? "good" : "bad") : "open";
  byId("reason").replaceChildren(...reasonOf(app));
  const facts = subject
    ? [
        subject.scenario?.name,
        `seed ${subject.seed ?? NOT_KNOWN}`,
        `law ${subject.scenario?.law?.law ?? NOT_KNOWN}`,
        `${run.bodies.size} robots`,
        subject.run,
        subject.folder && subject.folder !== subject.run ? `in ${subject.folder}` : "",
      ]
    : [];
  byId("facts").textContent = facts.filter(Boolean).join("  ·  ");
  document.title = `${verdict ? (verdict.ok ? "✓ " : "✗ ") : ""}${subject?.scenario?.name ?? "Clew"}, seed ${subject?.seed ?? "?"} – Clew`;
  byId("figures").replaceChildren(
    ...figuresOf(run).map(([name, value, beside]) =>
      element("div", { title: beside }, element("dt", {}, name), element("dd", {}, value, " ", element("small", {}, beside))),
    ),
  );
  const flaws = byId("flaws");
  flaws.hidden = run.flaws.length === 0;
  flaws.replaceChildren(
    element("b", {}, "Not complete"),
    element(
      "ul",
      {},
      ...run.flaws.slice(0, 20).map((flaw) => element("li", {}, flaw)),
      ...(run.flaws.length > 20 ? [element("li", {}, `and ${run.flaws.length - 20} more`)] : []),
    ),
  );
}

/** The least of the run; null: not known. @param {Run} run @returns {number | null} */
function clearanceOf(run) {
  const least = Math.min(...[...run.bodies.values()].map((body) => body.clearance.least));
  return run.verdict?.clearance_m_min ?? (Number.isFinite(least) ? least : null);
}

/** @param {Run} run @returns {[string, string, string][]} name, value, what stands beside it */
function figuresOf(run) {
  const { verdict } = run;
  if (!verdict && run.bodies.size === 0) return []; // nothing is known of it
  const apart =
    verdict?.separation_m_min ?? (Number.isFinite(run.separation.least) ? run.separation.least : null);
  const required = (/** @type {number | undefined | null} */ value) =>
    value ? `${value.toFixed(3)} m required` : value === 0 ? "must be above 0" : `required: ${NOT_KNOWN}`;
  /** @type {[string, string, string][]} */
  const figures = [
    ["Clearance", metres(clearanceOf(run)), required(run.subject?.clearance_m_required)],
    ["Separation", metres(apart), required(run.subject?.separation_m_required)],
    [
      "Steps",
      String(verdict?.switching_steps ?? run.steps.filter(({ end }) => end === "finished").length),
      `${verdict?.planning_events ?? (run.kind("scan.served").t ?? []).length} planning events of all robots`,
    ],
    [
      "Time",
      `${(verdict?.sim_s ?? run.end).toFixed(1)} s`,
      verdict ? `${verdict.path_m?.toFixed(2)} m driven by all` : "simulated",
    ],
  ];
  if (run.scenario.moving.length) {
    const passed = verdict?.moving_clearance_m_min ?? (run.passing.value.length ? run.passing.least : null);
    figures.splice(1, 0, ["To moving obstacles", metres(passed), "must be above 0 for driving robots"]);
  }
  if (!verdict) return figures;
  figures.splice(figures.length - 2, 0, [
    "Arrived",
    `${verdict.robots_arrived} of ${verdict.robots}`,
    verdict.goal_reached ? "goal reached" : "goal not reached",
  ]);
  const lost = Object.values(verdict.messages?.injected ?? {}).reduce((sum, each) => sum + each, 0);
  figures.push([
    "Messages",
    String(verdict.messages?.sent ?? "–"),
    `${lost} removed by faults, ${verdict.messages?.unaccounted ?? "–"} unaccounted`,
  ]);
  if (verdict.violations)
    figures.push(["Broken promises", String(verdict.violations), broken(verdict.violations_by_invariant, run.subject?.invariants)]);
  if (verdict.deaths?.length)
    figures.push([
      "Deaths",
      String(verdict.deaths.length),
      `${counted(verdict.successions?.length ?? 0, "succession")}, ${counted(verdict.heals?.length ?? 0, "heal")}`,
    ]);
  if (verdict.table_rms_m !== null && verdict.table_rms_m !== undefined)
    figures.push(["Table I", metres(verdict.table_rms_m), "RMS error against the paper"]);
  return figures;
}

/** @param {number} count @param {string} noun */
function counted(count, noun) {
  return `${count} ${noun}${count === 1 ? "" : "s"}`;
}

/** @param {Record<string, number>} counts @param {Record<string, string> | undefined} names */
function broken(counts, names) {
  return Object.entries(counts ?? {})
    .filter(([, count]) => count)
    .map(([code, count]) => `${code}${names?.[code] ? ` (${names[code]})` : ""} ${count}×`)
    .join(", ");
}

/** How things are at the time shown. @param {App} app */
function showNow(app) {
  const { run, time } = app;
  const strand = strandAt(run, time);
  byId("clock").textContent = `${time.toFixed(2)} s`;
  byId("strand-now").textContent = strand
    ? `${stepWords(run, time)} · strand ${orderOf(strand.order)}`
    : "no strand has formed yet";
  const chosen = run.bodies.get(app.robot);
  byId("robot-now").textContent = chosen ? robotNow(run, chosen, strand, time) : nearestNow(run, time);
}

/** @param {number[]} order leader first */
function orderOf(order) {
  const told = order.length <= 10 ? order : [...order.slice(0, 7), "…", order[order.length - 1]];
  return told.join(" ‹ ");
}

/** @param {Run} run @param {Body} body @param {any} strand @param {number} time */
function robotNow(run, body, strand, time) {
  body.goTo(time);
  const place = strand ? strand.order.indexOf(body.robot) : -1;
  const said = [
    `robot ${body.robot}${place === 0 ? ", which leads" : ""}: ${doingAt(run, body, time)}`,
    `${metres(body.clearance.at(time), 3)} clear`,
  ];
  const moving = fromMovers(run, body.x, body.y, time);
  if (moving < Infinity) said.push(`${metres(moving, 3)} from moving obstacles`);
  const progress = strand ? progressAt(run, body, strand, time, body.x, body.y) : NaN;
  if (!Number.isNaN(progress)) said.push(`${progress.toFixed(2)} m along the path`);
  const authority = place > 0 ? authorityAt(run, strand, place, time) : NaN;
  if (!Number.isNaN(authority)) said.push(`granted ${authority.toFixed(2)} m`);
  return said.join(" · ");
}
