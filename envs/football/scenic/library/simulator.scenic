"""The simulator that programs of Scenic4RL name; naming it has no effect."""

def GFootBallSimulator(settings=None, render=False, timestep=0.1):
    return "football"
