"""scripts/attack: broken and hostile input at every door, counted.

tally       what was tried, refused, done; what is a fault
documents   ways to spoil a JSON document
texts       ways to spoil any other file, and streams of bytes
corpus      valid inputs to begin from
readers     every reader, in this process
commands    every command's arguments, in this process, the work itself left out
kills       processes killed while they write
searches    identify, killed and gone on with
places      a full disk, no home, a cache of another processor
"""
