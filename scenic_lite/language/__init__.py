"""The parts of the language: classes, distributions, specifiers, operators, requirements, regions, fields."""
