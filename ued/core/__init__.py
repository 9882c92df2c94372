"""Interface of environments and methods: parameters, levels, `UPOMDP`, `Curriculum`, `Task`; checkpoints, seeds."""
