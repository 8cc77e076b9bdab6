// Which impacts of two recordings belong together.

// Two impacts are no pair if their times since the start differ by more than FAR of the earlier one; above DOUBTFUL of it, the pair is
// doubtful.
const [FAR, DOUBTFUL] = [0.1, 0.03];

/** Return the impacts of a list that have the same point and wall as an impact. */
function alike(impacts, { what, wall }) {
  return impacts.filter((one) => one.what === what && one.wall === wall);
}

/** Return the impact of a list of impacts of one point and wall whose onset is nearest to that of `impact`; undefined without one. */
function nearestIn(impacts, { onset }) {
  const gap = (one) => Math.abs(one.onset - onset);
  return impacts.reduce((best, one) => (best && gap(best) <= gap(one) ? best : one), undefined);
}

/**
 * Return { partner, isDoubtful } for an impact of the recording `own`: the impact of the recording `other` that belongs to it. Both have
 * the same point and wall, each is the nearest in time to the other, their times differ by little (FAR), and so do their numbers among the
 * impacts of this point and wall: by at most 1. The pair is doubtful if these numbers differ, or the times by more than DOUBTFUL.
 * Without such an impact, `partner` is undefined.
 */
export function partnerOf(impact, own, other) {
  const [mine, others] = [alike(own.impacts, impact), alike(other.impacts, impact)];
  const partner = nearestIn(others, impact);
  if (!partner || nearestIn(mine, partner) !== impact) return {};
  const since = Math.min(impact.onset - own.start, partner.onset - other.start);
  const gap = Math.abs(impact.onset - partner.onset);
  const steps = Math.abs(mine.indexOf(impact) - others.indexOf(partner));
  return gap > FAR * since || steps > 1 ? {} : { partner, isDoubtful: gap > DOUBTFUL * since || steps > 0 };
}
