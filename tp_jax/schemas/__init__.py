"""What files of results must be like to be read back, and how to say where one is not.

checking       a value against a schema -> one sentence that names the field
diagnosis      diagnosis.json
"""
