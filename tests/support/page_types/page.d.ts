// The names in the page's scripts that none of them declares.

/** The page's hooks, for feeds and tests: set by main.js. */
declare var clew: {
  take(index: number, batch: any): void;
  seek(time: number): void;
  choose(robot: number): void;
  draw(): void;
  readonly opened: Promise<void>;
  readonly time: number;
  readonly robot: number;
  readonly runs: Run[];
  readonly panes: Pane[];
  readonly charts: Chart[];
  readonly lanes: Lanes | null;
  readonly span: Span;
  readonly frames: number;
  frame(index?: number): { robot: number; x: number; y: number; heading: number; does: ReturnType<typeof doingAt> }[];
};

/** A path for each run that is watched: written by the viewer before live.js. */
declare const FEEDS: string[];
