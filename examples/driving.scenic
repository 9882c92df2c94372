# A car ahead drives at its own speed and brakes without warning; θ sets when it brakes, and how hard.
param map = localPath('straight_road.xodr')
param map_options = {'useCache': False, 'writeCache': False}
param render = False
model scenic.simulators.newtonian.driving_model

behavior Stopping(pace, after, force):
    do FollowLaneBehavior(target_speed=pace) for after seconds
    while True:
        take SetThrottleAction(0), SetBrakeAction(force)

speed = Range(4, 12)                              # m/s, ours at the start
gap = Range(3, 30)                                # m between the bumpers
pace = Range(1, 10)                               # m/s, of the car ahead
after = Range(0, 5)                               # s, until it brakes
force = Range(0.2, 1)                             # of its brakes

ego = new Car at (20, -1.85), with velocity (speed, 0)
lead = new Car ahead of ego by gap, with velocity (pace, 0), with behavior Stopping(pace, after, force)

require speed * speed / 10 < gap + pace * after + pace * pace / (14 * force)      # stopping in time is possible
terminate when lead.position.x > 580
