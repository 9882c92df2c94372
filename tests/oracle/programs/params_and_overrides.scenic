#! id: params_and_overrides
#! kind: static
#! n: 900; props: tag
param speed = Range(1, 2), mode = Uniform("a", "b")
param twice = 2 * globalParameters.speed
param 'long name' = globalParameters.twice + 1
ego = new Object at globalParameters.speed @ 0, with tag globalParameters.mode
scenario Main():
    setup:
        param extra = Normal(3, 1)
        far = new Object at 9 @ globalParameters.extra, with requireVisible False
