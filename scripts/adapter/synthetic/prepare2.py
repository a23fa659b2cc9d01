"""prepare2.py MODEL OUT.npz EPOCHS PACK MIX REAL.jsonl SYNTH_PREFIX -- MEASURE.jsonl...: the real cases in each epoch, with the synthetic ones of that epoch."""
import sys
from common import *
model,out,epochs,size,mix,real,synth=sys.argv[1:8]; meas=sys.argv[9:]
voc=Vocabulary(gguf.GGUFReader(model).fields); chance=random.Random(11)
read=lambda f:[json.loads(l) for l in open(f)]
P=[]; R=read(real); cnt=0
for e in range(int(epochs)):
    S=read(f'{synth}{e}.jsonl'); cnt+=len(S); g=packs(R,int(size),chance)+packs(S,int(size),chance); chance.shuffle(g)
    for own in g: P.append(sequence(voc,own,chance,"any",chance.random()<float(mix)))
M,names=[],[]
for zero in (False,True):
    for m in meas:
        for g in packs(read(m),12,chance):
            if not zero and len(g[0]['fixed'])==1: continue
            M.append(sequence(voc,g,chance,0 if zero else None)); names.append(json.dumps([[c["suite"]+(" 0" if zero else ""),c["answer"] is None] for c in g]))
def flat(L):
    d={}
    for k in L[0]:
        d[k]=np.concatenate([p[k] for p in L]); d[k+"_at"]=np.cumsum([0]+[len(p[k]) for p in L]).astype(np.int64)
    return d
r={"t_"+k:v for k,v in flat(P).items()}
if M: r|={"m_"+k:v for k,v in flat(M).items()}; r["m_names"]=np.array(names)
L=[len(p["tokens"]) for p in P]; np.savez_compressed(out,**r)
print(len(R),"real",cnt,"synthetic",len(P),"packs",sum(L),"tokens; longest",max(L),"targets",sum(len(p["targets"]) for p in P),"measure packs",len(M))
