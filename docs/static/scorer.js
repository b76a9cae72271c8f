// What a page tells a user comes before why it was decided and when it changed; the other numbers are Sphinx's own.
var Scorer = {
  score: ([docname, , , , score]) => (/^(decisions\/|changelog|faults|architecture|contributing)/.test(docname) ? score - 12 : score),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
