// Feeds the page from the viewer: the messages of every run, from the first one on, as they come.
//
// Rule 1: EventSource asks again by itself when the viewer is away, behind the message it has seen last.
// Rule 2: a run that has ended has nothing more to say; should the viewer go then, that is no trouble.
// Rule 3: an address that leads to a moment waits until the run has come that far.
// Rule 4: `anew` says that another run is told now than the page shows: it loads again, without its moment.
"use strict";
{
  const notice = document.createElement("p");
  notice.id = "notice";
  notice.setAttribute("role", "status");
  notice.textContent = "Waiting for a run to begin.";
  document.body.prepend(notice);
  /** @type {HTMLElement} */ (document.getElementById("badge")).textContent = "… Waiting";

  /** @param {string} text empty: hide it */
  const say = (text) => {
    notice.textContent = text;
    notice.hidden = text === "";
  };

  const moment = location.hash;
  let asked = new URLSearchParams(location.hash.slice(1)).get("t");
  const land = () => {
    if (asked === null || !(clew.runs[0]?.ended || clew.runs[0]?.end >= Number(asked))) return;
    history.replaceState(null, "", moment);
    dispatchEvent(new HashChangeEvent("hashchange"));
    asked = null;
  };

  /** @param {string} path of the run's feed @param {number} run its index */
  const follow = (path, run) => {
    const events = new EventSource(path);
    let ended = false;
    events.onmessage = (message) => {
      const batch = JSON.parse(message.data);
      ended ||= batch.ended === true;
      say("");
      clew.take(run, batch);
      land();
    };
    events.onerror = () => {
      if (ended) events.close();
      else say("The viewer is away; asking again.");
    };
    events.addEventListener("anew", () => location.replace(location.pathname));
  };
  FEEDS.forEach(follow);
}
