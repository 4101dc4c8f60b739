"""Words that UPPAAL reserves and this subset does not have, by the construct that they belong to."""

_BY_CONSTRUCT = {
    "a structure": "struct",
    "a type that is not integral": "double string",
    "a scalar set": "scalar",
    "a meta variable": "meta",
    "a hybrid clock": "hybrid",
    "a priority": "priority",
    "an external function": "import",
    "a dynamic template": "dynamic spawn exit numOf foreach",
    "a Gantt chart": "gantt",
    "a progress measure": "progress",
    "a global update": "before_update after_update",
    "this statement": "switch case default break continue assert",
    "this operator": "xor",
    "this section": "query IO",
    "a template written as text": "process state trans commit branchpoint",
    "a function on floating-point numbers": "random fabs fmod pow sqrt exp ln log sin cos tan ceil floor round",
    "a built-in function": "abs",
}
REFUSED_WORDS = {word: construct for construct, words in _BY_CONSTRUCT.items() for word in words.split()}
