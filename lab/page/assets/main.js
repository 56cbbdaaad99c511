window.clew = { runs: [], take(runIndex, batch) { (this.runs[runIndex] ??= []).push(batch); } };
