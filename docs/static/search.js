// Ranks search results (html_search_scorer): pages and sections first, then names that contain the word. A name that is the
// word stays on top, unless it is a parameter or a member of C: those come last.
var Scorer = {
  score: ([, , , description, score]) =>
    /^C (function parameter|macro parameter|member)\b/.test(description) ? score - 100 : score,
  objNameMatch: 30,
  objPartialMatch: 1,
  objPrio: {},
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
