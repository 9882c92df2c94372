#! id: broken_in_monitor; kind: error
#! tags: monitor:fault
#! run: dynamic; steps: 5
behavior S():
    take 'x'
monitor M():
    wait
    x = 1 / 0
    wait
ego = new Object with behavior S()
require monitor M()
