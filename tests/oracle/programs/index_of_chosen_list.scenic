#! id: index_of_chosen_list
#! kind: static
#! n: 600
rows = [(1, 7), (2, 8, 9)]
row = Uniform(*rows)
ego = new Object at row[0] @ row[1]
param count = len(row)
param last = row[-1]
