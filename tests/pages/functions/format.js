// Functions that tests/pages/test_format.py runs in a page.
import { inRadians, typed, valueText } from "../../../fmu_src/chain_impact/pages/browser/scene/angles.js";

export const roundOff = () => {
  const shown = (all, largest) => withoutRoundOff(all.map((values) => ({ values })), largest).map(({ values }) => values);
  return [shown([[0.5, -2e-14], [1e-11]], 0), shown([[-1.96e-14]], 50)];
};

export const angles = () => {
  const some = Array.from({ length: 200 }, (_, k) => (k - 100) * (k % 3 ? Math.PI / 180 : 0.0437));
  return [some.map((value) => [value, typed(valueText(value, "rad"), "rad")]), valueText(inRadians("-25 deg", "rad"), "rad"),
    valueText(0.5, "rad"), valueText(Math.PI, "m")];
};
