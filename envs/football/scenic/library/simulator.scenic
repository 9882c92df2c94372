"""The simulator that programs of Scenic4RL name: here there is one only, and naming it changes nothing."""

def GFootBallSimulator(settings=None, render=False, timestep=0.1):
    return "football"
