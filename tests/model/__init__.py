"""An explicit-state model of views and fences: are the rules enough, and is each of them needed?

`search.py` tries every order of events within bounds, breadth first. With all rules no property may break.
Without one of them, or a few that cover each other, one does, and the search gives a shortest trace.
`pytest tests/model` runs the short form. `python -m tests.model --seconds 60` prints the tables and runs the
long searches; `--trace` adds the traces.

What is modelled:
- one register (epoch with life, turn, who may move), raises, turns, the operator's stop and release,
  restarts of the world;
- two or three bodies that stop at once or brake;
- robots in the four states, their lives and restarts; odometry in time or late; reports, formation, path and
  authority; scans with the fence that they bear.

A sent message stays in a set: it may arrive late, often, out of order or never. So loss, delay, duplication,
reordering and a frozen process need no events of their own. Robots raise whenever they like: why is liveness.

What is not modelled:
- geometry: a place is a count of motions, a strand drives one step per robot, and F6 (b) and (c), what is
  taken out of a scan, is left to the exploration of the real cores; how a strand lies is a small model of
  its own, `folding/`;
- liveness: timeouts, suspicion, quotas, `stood_s`, raises of outsiders that the register holds over all, and
  who leads and how many are members, which all tells. To refuse, hold or delay a raise is to lose it;
- lies.

| file | subject |
|---|---|
| `rules.py` | every rule in one sentence, with its letter of the design and the schedules that it answers |
| `values.py`, `state.py` | fence, bodies and robots; what is sent, and one moment of all |
| `register.py`, `world.py` | what the register takes; what a change of the fence does; operator; restart |
| `bodies.py`, `properties.py` | which orders a body obeys (F1); what the judge asks of each |
| `robots.py`, `acting.py` | what a robot learns (F4, F5); what it does of its own accord (F2, F6) |
| `coordinator.py` | turns, formation, all (F4) |
| `forgetting.py`, `setting.py` | the reductions and what they rest on; the bounds |
| `folding/` | strands on a grid: robots of one that folds back come too near |
| `search.py`, `searches.py` | breadth first; which searches are clean, and what breaks without which rules |
"""
