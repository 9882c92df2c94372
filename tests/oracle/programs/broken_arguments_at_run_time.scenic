#! id: broken_arguments_at_run_time; kind: error
#! tags: behavior:arguments
#! run: dynamic; steps: 5
behavior S(k):
    take 'x'
behavior B():
    take 'y'
    do S()
ego = new Object with behavior B()
