#! id: broken_class_call
#! kind: error
#! tags: a class called like a function
class Post:
    width: 2
ego = new Post at 0 @ 0
b = Post()
