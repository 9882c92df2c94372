#! id: broken_ego_type
#! kind: error
#! tags: an ego that is none
x = 3
ego = x
