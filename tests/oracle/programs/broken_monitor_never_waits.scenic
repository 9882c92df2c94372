#! id: broken_monitor_never_waits; kind: error
#! tags: monitor:wait
#! run: dynamic; steps: 5
behavior S():
    take 'x'
monitor M():
    x = 3
ego = new Object with behavior S()
require monitor M()
