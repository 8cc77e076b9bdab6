// Functions that tests/pages/test_twins.py runs in a page.
import { unpack } from "../../../fmu_src/chain_impact/pages/browser/player/packed_recording.js";
import { framesOf, impactsUntil, timesOf } from "../../../fmu_src/chain_impact/pages/browser/recording/frames.js";
import { frameTimes } from "../../../fmu_src/chain_impact/pages/browser/recording/pacing.js";
import { viewOf } from "../../../fmu_src/chain_impact/pages/browser/recording/view.js";
import { wallsAt } from "../../../fmu_src/chain_impact/pages/browser/scene/geometry.js";
import { bodiesOf, railOf } from "../../../fmu_src/chain_impact/pages/browser/scene/bodies.js";

export const framesInPage = ([start, stop, spans, impactTime, maxFrames, rate]) => {
  const { times, frameRate } = frameTimes(start, stop, spans, impactTime, maxFrames, rate);
  return [[...times], frameRate];
};

export const viewInPage = ([points, walls, radius, pinned, carriage]) => {
  const [x, y] = [0, 1].map((axis) => points.flatMap((row) => row.map((point) => point[axis])));
  return viewOf(x, y, points[0].length, walls, radius, pinned, carriage);
};

export const shapes = ([contents, bases, size]) => {
  const scene = sceneOf(contents);
  const valueOf = (name) => scene.parameters.find((parameter) => parameter.name === name)?.start;
  const [walls, bodies] = [wallsAt(scene, valueOf), bodiesOf(scene, valueOf)];
  const rail = railOf(bases, size, valueOf);
  const rate = frameRateOf(scene, valueOf, valueOf("simulation.stop_time"));
  return { walls, bodies, rail, ranges: rangesOf(scene, valueOf), rate };
};

export const shownInPage = ([packed, impactTime]) => {
  const rows = unpack(packed);
  const [start, stop] = [rows.time[0], rows.time.at(-1)];
  const impacts = impactsUntil(packed.impacts, stop);
  const frames = timesOf(impacts, start, stop, rows.pointCount, impactTime, packed.frameRate);
  const { time, x, y, view, anchor, pin } = framesOf({ ...rows, impacts }, frames);
  return { time: [...time], x: [...x], y: [...y], view, anchor, pin };
};
