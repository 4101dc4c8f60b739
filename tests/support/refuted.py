"""A small UPPAAL file with a requirement that does not hold, and with the variables of a recording."""

REFUTED = """<nta><declaration>clock x; int ee = 6, command = -1, actuator[1];</declaration><template><name>P</name>
<location id="a"><name>A</name><label kind="invariant">x &lt;= 3</label></location>
<location id="b"><name>B</name></location>
<init ref="a"/><transition><source ref="a"/><target ref="b"/></transition></template>
<system>system P;</system>
<queries><query><formula>A[] P.A</formula><comment>[stays] It stays.</comment></query></queries></nta>
"""
