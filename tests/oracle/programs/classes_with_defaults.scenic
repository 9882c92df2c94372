#! id: classes_with_defaults
#! kind: static
#! tags: classes, inheritance, random and dependent defaults
#! props: paint,weight,reach; n: 500
class Marker:
    paint: Uniform('red', 'blue')
    weight: Range(1, 3)
    reach: self.weight * 2
    requireVisible: False
class HeavyMarker(Marker):
    weight: 10 + self.width
    width: Range(1, 2)
ego = new Marker at 0 @ 0
b = new Marker at 10 @ 0, with weight 7
c = new HeavyMarker at 20 @ 0, with paint 'green'
