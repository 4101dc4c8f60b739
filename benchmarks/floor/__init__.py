"""The floor: the same hops with nothing in them. Each module is a program; none imports the product's code."""
