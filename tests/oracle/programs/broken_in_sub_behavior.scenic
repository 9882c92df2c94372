#! id: broken_in_sub_behavior; kind: error
#! tags: behavior:fault
#! run: dynamic; steps: 5
behavior S(k):
    take 'x'
    take 1 / k
behavior B():
    do S(0)
ego = new Object with behavior B()
