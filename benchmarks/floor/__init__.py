"""The floor: the same process chain without logic. Each module is a program without the product's code."""
