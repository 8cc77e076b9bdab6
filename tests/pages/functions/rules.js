// Functions that tests/pages/test_rules.py runs in a page.
import { isRuleTrue, numberIn } from "../../../fmu_src/chain_impact/pages/browser/scene/rules.js";

export const evaluated = ([rules, values]) => {
  const valueOf = (name) => values[name];
  return rules.map((rule) => [isRuleTrue(rule, valueOf), numberIn(rule, valueOf)]);
};
