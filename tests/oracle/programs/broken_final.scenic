#! id: broken_final
#! kind: error
#! tags: final property
class Foo:
    bar[final]: 1
ego = new Foo at 0 @ 0, with bar 3
