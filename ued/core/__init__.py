"""The seam between environments and methods: parameters, levels, `UPOMDP`, `Curriculum`, `Task`; checkpoints, seeds."""
