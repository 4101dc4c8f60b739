"""Fischer's protocol for mutual exclusion, written anew from the literature (Lamport 1987), in UPPAAL's format."""

from __future__ import annotations

_MODEL = """<nta>
<declaration>int[0, {count}] id;</declaration>
<template><name>P</name><parameter>const int[1, {count}] pid</parameter>
<declaration>clock x;</declaration>
<location id="a"><name>Idle</name></location>
<location id="b"><name>Request</name><label kind="invariant">x &lt;= 2</label></location>
<location id="c"><name>Wait</name></location>
<location id="d"><name>Critical</name></location>
<init ref="a"/>
<transition><source ref="a"/><target ref="b"/>
<label kind="guard">id == 0</label><label kind="assignment">x = 0</label></transition>
<transition><source ref="b"/><target ref="c"/>
<label kind="guard">x &lt;= 2</label><label kind="assignment">x = 0, id = pid</label></transition>
<transition><source ref="c"/><target ref="b"/>
<label kind="guard">id == 0</label><label kind="assignment">x = 0</label></transition>
<transition><source ref="c"/><target ref="d"/>
<label kind="guard">x &gt; 2 &amp;&amp; id == pid</label></transition>
<transition><source ref="d"/><target ref="a"/>
<label kind="assignment">id = 0</label></transition>
</template>
<system>system P;</system>
</nta>"""

EXCLUSION = "A[] forall (i : int[1, {count}]) forall (j : int[1, {count}]) P(i).Critical && P(j).Critical imply i == j"


def fischer(count: int) -> tuple[bytes, str]:
    """The file for ``count`` processes, and the query of its mutual exclusion."""
    return _MODEL.format(count=count).encode(), EXCLUSION.format(count=count)
