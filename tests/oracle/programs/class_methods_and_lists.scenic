#! id: class_methods_and_lists
#! kind: static
#! tags: methods, lists, comprehensions, functions
#! n: 200
class Post:
    height: 3
    def shadow(self, factor):
        return self.height * factor + self.x
def place(i, gap=4):
    return i * gap @ -i
posts = [new Post at place(i), with height (i + 1) for i in range(4)]
ego = posts[1]
param heights = sum([p.height for p in posts]), shadow = posts[2].shadow(0.5), many = len(posts)
