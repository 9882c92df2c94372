#! id: broken_region
#! kind: error
#! tags: on something that is no region
spot = 'middle'
ego = new Object on spot
