"""How recordings are drawn; imported by `end_effector_hal.trace` only when a figure is wanted."""
