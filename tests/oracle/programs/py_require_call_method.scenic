#! id: py_require_call_method
#! kind: static; tags: python
#! n: 500
ego = new Object at 0 @ 0
class B:
    size: Range(1, 2)
    def big(self, t):
        return self.size > t
b = new B at 10 @ 0
require b.big(1.5)
param s = b.size
