"""All contacts in time.

sweep    free time and contact in turn, each proved
lasting  contacts that last
answers  results out of what was proved
"""
