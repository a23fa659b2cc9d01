"""synth.py OUT.jsonl ROBOTS CASES SEED TAIL: synthetic robots from the lexicon and the verb frames."""
import sys,random,json,glob,tomllib,re,collections
out,robots,cases,seed,tail=sys.argv[1],int(sys.argv[2]),int(sys.argv[3]),int(sys.argv[4]),open(sys.argv[5]).read()
R=random.Random(seed)
LANGS=['en','de','fr','es','ja']
N=[];seen=set()
for f in sorted(glob.glob('/work/t/data/lex/*.tsv')):
    for l in open(f):
        p=l.rstrip('\n').split('\t')
        if len(p)!=7 or p[0] in seen: continue
        seen.add(p[0])
        ways={k:[w.strip().replace('’',"'") for w in c.split('/') if w.strip()] for k,c in zip(LANGS,p[2:])}
        if all(ways.values()): N.append(dict(name=p[0],cls=p[1],ways=ways))
V=[];vs=set()
for f in sorted(glob.glob('/work/t/data/verbs/*.toml')):
    for w in tomllib.load(open(f,'rb'))['word']:
        if w['name'] in vs: continue
        vs.add(w['name']); V.append(w)
BY=collections.defaultdict(list)
for n in N: BY[n['cls']].append(n)
NAMES="Anna Ben Carla David Elena Fatma Georg Hanna Ivan Julia Kenji Lena Marco Nadia Olga Pablo Quentin Rosa Samir Tomas Ursula Viktor Wanda Yuki Zoe Ahmed Amélie Jonas Lucía Mateo Sofia Emil Frieda Grace Hugo Ines Jakob Kofi Leila Miguel Noor Pierre Priya Ruth Sven Thandi Mr_Becker Mrs_Lopez Dr_Singh Ms_Tanaka Mr_Dubois Mrs_Okafor Mr_Rossi Mrs_Novak Dr_Klein Mr_Sato Mrs_Haddad".split()
def anynoun(cls): return R.choice(BY[cls])
ADJ={ # en, de stem, fr (m f mp fp, before?), es (m f mp fp), ja
'red':('rot','rouge rouge rouges rouges','rojo roja rojos rojas','赤い'),'blue':('blau','bleu bleue bleus bleues','azul azul azules azules','青い'),
'green':('grün','vert verte verts vertes','verde verde verdes verdes','緑の'),'yellow':('gelb','jaune jaune jaunes jaunes','amarillo amarilla amarillos amarillas','黄色い'),
'white':('weiß','blanc blanche blancs blanches','blanco blanca blancos blancas','白い'),'black':('schwarz','noir noire noirs noires','negro negra negros negras','黒い'),
'grey':('grau','gris grise gris grises','gris gris grises grises','灰色の'),'brown':('braun','marron marron marron marron','marrón marrón marrones marrones','茶色い'),
'big':('groß','+grand grande grands grandes','grande grande grandes grandes','大きい'),'small':('klein','+petit petite petits petites','pequeño pequeña pequeños pequeñas','小さい'),
'old':('alt','+vieux vieille vieux vieilles','viejo vieja viejos viejas','古い'),'new':('neu','+nouveau nouvelle nouveaux nouvelles','nuevo nueva nuevos nuevas','新しい'),
'left':('link','de_gauche '*4,'de_la_izquierda '*4,'左の'),'right':('recht','de_droite '*4,'de_la_derecha '*4,'右の'),
'front':('vorder','de_devant '*4,'de_delante '*4,'手前の'),'back':('hinter','de_derrière '*4,'de_atrás '*4,'奥の')}
VOW='aeiouhéèêàâîôûœ'
def de(way,case,adj):
    pl=way.startswith('pl:'); way=way[3:] if pl else way
    art,rest=way.split(' ',1) if ' ' in way else ('die',way)
    g='pl' if pl else {'der':'m','die':'f','das':'n'}.get(art,'f')
    A={'nom':dict(m='der',f='die',n='das',pl='die'),'acc':dict(m='den',f='die',n='das',pl='die'),'dat':dict(m='dem',f='der',n='dem',pl='den'),'gen':dict(m='des',f='der',n='des',pl='der')}[case][g]
    if case=='dat' and g=='pl' and rest[-1] not in 'ns': rest+='n'
    if case=='gen' and g in 'mn' and ' ' not in rest: rest+='es' if rest[-1] in 'szßxd' else 's'
    a=''
    if adj:
        stem=ADJ[adj][0]; a=stem+('e' if (case=='nom' and g!='pl') or (case=='acc' and g in 'fn') else 'en')+' '
    return f'{A} {a}{rest}'
def fr(way,prep,adj):
    if way.startswith("l'"): art,rest='l',way[2:]
    else: art,rest=way.split(' ',1)
    if adj:
        forms=ADJ[adj][1].split(); before=forms[0].startswith('+'); i={'le':0,'la':1,'les':2,'l':0}[art]
        form=forms[i].lstrip('+').replace('_',' ')
        if before:
            rest=form+' '+rest
            if art=='l': art='le'
        else: rest=rest+' '+form
    if prep=='à': pre={'le':'au ','la':'à la ','les':'aux ','l':"à l'"}[art]
    elif prep=='de': pre={'le':'du ','la':'de la ','les':'des ','l':"de l'"}[art]
    else: pre={'le':'le ','la':'la ','les':'les ','l':"l'"}[art]
    return pre+rest
def es(way,prep,adj):
    art,rest=way.split(' ',1)
    if adj: rest+=' '+ADJ[adj][2].split()[{'el':0,'la':1,'los':2,'las':3}[art]].replace('_',' ')
    t=f'{art} {rest}'
    if prep=='a': return 'al '+rest if art=='el' else 'a '+t
    if prep=='de': return 'del '+rest if art=='el' else 'de '+t
    return t
UNITS={'degC':(5,95,'{} degrees','{} Grad','{} degrés','{} grados','{}度'),'percent':(5,100,'{} percent','{} Prozent','{} pour cent','{} por ciento','{}パーセント'),
'min':(2,60,'{} minutes','{} Minuten','{} minutes','{} minutos','{}分'),'litre':(1,20,'{} litres','{} Liter','{} litres','{} litros','{}リットル'),'lux':(50,900,'{} lux','{} Lux','{} lux','{} lux','{}ルクス'),
'':(1,12,'{}','{}','{}','{}','{}')}
def render(e,lang,mod,short):
    """e: an entity of the scene; mod: a case or a preposition."""
    if 'value' in e:
        u=UNITS.get(e['unit'],UNITS['']); return u[2+LANGS.index(lang)].format(e['value'])
    if 'proper' in e:
        n=e['proper'].replace('_',' ')
        if lang=='fr': return {'à':'à '+n,'de':("d'" if n[0] in 'AEIOUÉ' else 'de ')+n}.get(mod,n)
        if lang=='es': return {'a':'a '+n,'de':'de '+n}.get(mod,n)
        if lang=='ja': return n+R.choice(['さん','さん',''])
        if lang=='de': return (n.replace('Mr ','Herr ').replace('Mrs ','Frau ').replace('Ms ','Frau ').replace('Herr ','Herrn ' if mod in('acc','dat') else 'Herr '))
        return n
    adj=None if short else e['adj']
    w=R.choice(e['noun']['ways'][lang]) if R.random()<.55 else e['noun']['ways'][lang][0]
    if lang=='en': return 'the '+(adj+' ' if adj else '')+w
    if lang=='de': return de(w,mod or 'nom',adj)
    if lang=='fr': return fr(w,mod,adj)
    if lang=='es': return es(w,mod,adj)
    return (ADJ[adj][3] if adj else '')+w
CON=[('in dem ','im '),('an dem ','am '),('zu dem ','zum '),('zu der ','zur '),('von dem ','vom '),('bei dem ','beim '),('in das ','ins '),('an das ','ans ')]
def fill(frame,lang,args,short):
    def one(m):
        i=0 if m[1]=='X' else 1; return render(args[i],lang,m[3] or '',short[i])
    t=re.sub(r'\{([XY])(:(\w+|à))?\}',one,frame)
    if lang=='de':
        for a,b in CON:
            if R.random()<.9: t=t.replace(' '+a,' '+b)
            if t.lower().startswith(a): t=b.capitalize()+t[len(a):]
    return t[:1].upper()+t[1:] if R.random()<.85 else t[:1].lower()+t[1:]
def clsname(c): return {'value':'NUMBER'}.get(c,c.upper())
PARAM={'thing':['ITEM','THING','OBJECT'],'food':['FOOD','ITEM'],'plant':['PLANT','BED'],'animal':['ANIMAL'],'person':['PERSON','GUEST','WHO'],'device':['DEVICE'],'container':['CONTAINER','BOX','FURNITURE'],'furniture':['FURNITURE','SURFACE','PLACE'],'place':['PLACE','ROOM','AREA','SPOT'],'door':['DOOR','OPENING']}
INTRO=["You read what a person wants from a {r} and say which goals it has to reach.","You read what a person wants a robot to do in {p} and say which goals the robot has to reach.","You turn what a person says to a {r} into its goals."]
END='Join several goals with " & ". Say only what the person asks for, with the names of the lists.\n\nIf the person asks for something that is not in the lists, says nothing that can be done, or only wants to know something, ask back instead: question: and one short question.'
BUT={'en':[', but ','. But ','; ',', and '],'de':[', aber ','. Aber ','; ',', und '],'fr':[', mais ','. Mais ',' ; ',', et '],'es':[', pero ','. Pero ','; ',', y '],'ja':['。ただし、','。でも','。']}
WITHOUT={'en':'without','de':'ohne','fr':'sans','es':'sin'}
ALSO={'en':[' And ','. ',', and ',' Also: ','; '],'de':['. Und ','. ',', und ','. Außerdem: ','; '],'fr':['. Et ','. ',', et ',' ; '],'es':['. Y ','. ',', y ','; '],'ja':['。それから','。','。あと、']}
FIRST={'en':[('First: ',' Then: '),('',' After that: '),('',' Then: '),('Start with this: ',' When that is done: ')],'de':[('Zuerst: ',' Danach: '),('',' Anschließend: '),('',' Und dann: '),('Erst mal: ',' Wenn das erledigt ist: ')],'fr':[("D'abord : ",' Ensuite : '),('',' Après ça : '),('',' Puis : ')],'es':[('Primero: ',' Después: '),('',' Luego: '),('',' Cuando acabes: ')],'ja':[('まず、','その後、'),('','それが終わったら、'),('','次に、')]}
LEAVE={'en':['leave {X} alone','hands off {X}',"don't touch {X}",'{X} stays as it is'],'de':['lass {X:acc} in Ruhe','Finger weg von {X:dat}','{X} bleibt, wie es ist','fass {X:acc} nicht an'],'fr':['ne touche pas {X:à}','laisse {X} tranquille','pas touche {X:à}'],'es':['no toques {X}','deja {X} en paz','ni se te ocurra tocar {X}'],'ja':['{X}には触らないで','{X}はそのままにしておいて','{X}はいじらないで']}
def strip(t): return t.rstrip(' .!。！?？')
NO={'en':['No, {s}','Not that. {s}','I meant: {s}','No no. {s}'],'de':['Nein, {s}','Nicht das. {s}','Ich meinte: {s}','Falsch. {s}'],'fr':['Non, {s}','Pas ça. {s}','Je voulais dire : {s}'],'es':['No, {s}','Eso no. {s}','Quería decir: {s}'],'ja':['違う、{s}','そうじゃなくて、{s}','いや、{s}']}
AND={'en':['And {s}','Also: {s}','Oh, and {s}','{s}'],'de':['Und {s}','Außerdem: {s}','Ach ja: {s}','{s}'],'fr':['Et {s}','Aussi : {s}','Ah, et {s}','{s}'],'es':['Y {s}','También: {s}','Ah, y {s}','{s}'],'ja':['あと、{s}','それから{s}','{s}']}
AFTER={'en':['Afterwards: {s}','And then {s}','After that: {s}'],'de':['Danach: {s}','Und hinterher: {s}','Anschließend: {s}'],'fr':['Ensuite : {s}','Et après : {s}','Puis {s}'],'es':['Después: {s}','Y luego: {s}','Cuando termines: {s}'],'ja':['その後、{s}','終わったら、{s}']}
BEFORE={'en':['But first: {s}','Before that: {s}','Do this first: {s}'],'de':['Aber vorher: {s}','Zuerst noch: {s}','Davor: {s}'],'fr':["Mais d'abord : {s}",'Avant ça : {s}'],'es':['Pero antes: {s}','Antes de eso: {s}','Primero: {s}'],'ja':['その前に、{s}','でもまず、{s}']}
DROP={'en':['Forget about {X}','Leave {X} out of it','Not {X} after all','{X} is not necessary'],'de':['Vergiss {X:acc}','{X:acc} kannst du weglassen','{X} doch nicht','{X} ist nicht nötig'],'fr':['Oublie {X}','Finalement pas {X}',"{X}, ce n'est pas la peine"],'es':['Olvida {X}','{X} al final no','{X} no hace falta'],'ja':['{X}はやっぱりいい','{X}はなしで','{X}は要らない']}
def lowc(s,lang): return s if lang in('de','ja') and not s[:1].isupper() else s[:1].lower()+s[1:] if lang!='de' else s
def robot(n):
    words=[]; pool=V[:]; R.shuffle(pool)
    for w in pool:
        if len(words)>=R.randint(6,12): break
        if w not in words:
            words.append(w)
            o=next((x for x in V if x['name']==w.get('opposite')),None)
            if o and o not in words and R.random()<.8: words.append(o)
    R.shuffle(words)
    need=collections.Counter(t for w in words for t in w['takes'] if not t.startswith('value'))
    ents=[];used=set();byc=collections.defaultdict(list)
    def add(cls):
        if cls=='person' and R.random()<.5:
            p=R.choice(NAMES)
            if p.lower() in used: return
            used.add(p.lower()); e=dict(proper=p,name=p.replace('_',' '),cls=cls)
        else:
            for _ in range(30):
                noun=anynoun(cls); ways={w.lower() for k in LANGS for w in noun['ways'][k]}|{noun['name']}
                if not ways&used: break
            else: return
            used.update(ways); e=dict(noun=noun,adj=None,name=noun['name'],cls=cls)
            if R.random()<.16 and cls!='person':
                a=R.choice(list(ADJ)); e['adj']=a; e['name']=a+' '+noun['name']
                if R.random()<.5:
                    b=R.choice([x for x in ADJ if x!=a]); f=dict(noun=noun,adj=b,name=b+' '+noun['name'],cls=cls,twin=True); e['twin']=True
                    ents.append(f); byc[cls].append(f)
        ents.append(e); byc[cls].append(e)
    for c in need:
        for _ in range(R.randint(2,5)): add(c)
    for c in R.sample(list(BY),3):
        if c not in need: add(c)
    R.shuffle(ents)
    placecls={'place','furniture','container','door','device'}|({'person'} if R.random()<.5 else set())
    spots=[e for e in ents if e['cls'] in('place','furniture','container')]
    obj,pla=[],[]
    prop={c:R.choice([c,None,{'door':'opens','container':'opens','device':'switch','furniture':'has a top'}.get(c,c)]) for c in BY}
    for e in ents:
        d=[]
        if e['cls'] in placecls:
            if prop[e['cls']]: d.append(prop[e['cls']])
            if e['cls'] in('door','container') and R.random()<.4: d.append('open')
            if e['cls']=='device' and R.random()<.4: d.append('on')
            if e['cls']=='place' and R.random()<.1: d.append('robot here')
            pla.append((e['name'],', '.join(d)))
        else:
            if spots and R.random()<.85: d.append(R.choice(['at ','on ','in '])+R.choice(spots)['name'])
            if prop[e['cls']] and e['cls']!='thing': d.insert(R.randint(0,len(d)),prop[e['cls']])
            obj.append((e['name'],', '.join(d)))
    def shown(w):
        ps=[]
        for t in w['takes']:
            p='AMOUNT' if t.startswith('value') else R.choice(PARAM[t])
            while p in ps: p+='2'
            ps.append(p)
        return f"- {w['name']}({', '.join(ps)}): {w['means']}"
    place=R.choice(BY['place'])['name']
    sys_=R.choice(INTRO).format(r=R.choice([f'robot in the {place}','household robot','robot',f'robot that works at the {place}']),p=f'the {place}')+'\n\nA goal is one of these:\n'+'\n'.join(map(shown,words))+'\n\n'+END
    own=tail
    if R.random()<.5: own=own.replace('- never GOAL until',R.choice(['- behind never and always also: robot_at(PLACE)\n','- behind never and always also: robot_at(PLACE), holding(ITEM)\n','- behind never and always also: held(THING)\n'])+'- never GOAL until')
    sys_+=own
    lead='Objects:\n'+''.join(f'- {a}: {b}\n' if b else f'- {a}\n' for a,b in obj)+'Places:\n'+''.join(f'- {a}: {b}\n' if b else f'- {a}\n' for a,b in pla)+'\nInstruction:'
    def pick(w,miss=False):
        args=[]
        for t in w['takes']:
            if t.startswith('value:') or t=='value':
                u=t[6:]; lo,hi=UNITS.get(u,UNITS[''])[:2]; args.append(dict(value=R.randint(lo,hi),unit=u))
            else:
                c=[e for e in byc[t] if e not in args]
                if not c: return None
                args.append(R.choice(c))
        return args
    def written(w,args): return f"{w['name']}({', '.join(str(a['value'])+(' '+a['unit'] if a['unit'] else '') if 'value' in a else a['name'] for a in args)})"
    res=[]
    def shorts(args): return [bool(a.get('adj')) and not a.get('twin') and R.random()<.5 for a in args]
    def say(w,args,lang): return fill(R.choice(w[lang]),lang,args,shorts(args))
    def end(t): return t if t.rstrip()[-1:] in '.!?。！？…' else t+R.choice(['.','','.'])
    def one(w,args,lang): return strip(say(w,args,lang))
    def dialogue(lang):
        w=R.choice(words); args=pick(w)
        if not args: return
        A=written(w,args); k=R.random(); says=end(say(w,args,lang))
        w2=R.choice(words); b=pick(w2)
        if not b or written(w2,b)==A: return
        B=written(w2,b); t=one(w2,b,lang)
        if k<.22:
            tw=[x for x in args if x.get('twin')]
            if not tw: return
            x=tw[0]; o=next(e for e in ents if e.get('twin') and e['noun'] is x['noun'] and e is not x)
            two=[x['name'],o['name']]; R.shuffle(two)
            says=end(fill(R.choice(w[lang]),lang,args,[y is x for y in args]))
            q=f"question: Which {x['noun']['name'].split()[-1]} do you mean: {two[0]}{R.choice([', or ',' or '])}{two[1]}?"
            np=fill('{X:acc}' if lang=='de' else '{X}',lang,[x],[False])
            return says,q,end(np),A
        if k<.38:
            i=R.randrange(len(args)); c=[e for e in byc.get(args[i].get('cls'),[]) if e not in args]
            if not c: return
            wrong=args[:]; wrong[i]=R.choice(c)
            return says,written(w,wrong),end(R.choice(NO[lang]).format(s=lowc(one(w,args,lang),lang))),A
        if k<.5: return says,A,end(R.choice(AND[lang]).format(s=lowc(t,lang))),A+' & '+B
        if k<.62: return says,A,end(R.choice(AFTER[lang]).format(s=lowc(t,lang))),A+' then '+B
        if k<.7: return says,A,end(R.choice(BEFORE[lang]).format(s=lowc(t,lang))),B+' then '+A
        if k<.84:
            f=fill(R.choice(w2['not_'+lang]),lang,b,shorts(b))
            if w2['name']==w.get('opposite') and b[0]==args[0] or w2 is w and b[0]==args[0]: return
            return says,A,end(f),A+' & never '+B
        x=b[0]
        if 'value' in x or x in args: return
        both=[(A,B),(B,A)][R.random()<.5]
        return end(strip(says)+R.choice([y for y in ALSO[lang] if not y.endswith(('and ','und ','et ','y '))])+t),' & '.join(both),end(fill(R.choice(DROP[lang]),lang,[x],shorts([x]))),A
    tries=0
    while len(res)<cases and tries<cases*5:
        tries+=1
        lang=R.choices(LANGS,[16,22,20,20,22])[0]; w=R.choice(words); args=pick(w)
        if not args: continue
        kind=R.random(); a=None
        if R.random()<.09:
            d=dialogue(lang)
            if d: res.append(dict(suite=f'synthetic-{seed}-{n}',id=f's{seed}-{n}-{len(res)}',tags=[lang],fixed=[['system',sys_]],lead=lead,instruction=' '+' '.join(d[0].split()),rounds=[[d[1],' '.join(d[2].split())]],answer=d[3]))
            continue
        if kind<.60: t,a=end(say(w,args,lang)),written(w,args)
        elif kind<.68:
            w2=R.choice(words); args2=pick(w2)
            if not args2 or written(w2,args2)==written(w,args) or w2['name']==w.get('opposite'): continue
            t=strip(say(w,args,lang)); s=say(w2,args2,lang); j=R.choice(ALSO[lang])
            if j.endswith(('and ',', ','und ','et ','y ')): s=s[:1].lower()+s[1:] if lang!='de' else s
            t=end(t+j+s); a=written(w,args)+' & '+written(w2,args2)
        elif kind<.81:
            w2=R.choice(words); args2=pick(w2)
            if not args2 or written(w2,args2)==written(w,args) or w2['name'] in (w['name'],w.get('opposite')) and args2[0]==args[0]: continue
            if R.random()<.25:
                x=args2[0]
                if 'value' in x or x in args: continue
                s=fill(R.choice(LEAVE[lang]),lang,[x],shorts([x])); c=f"untouched({x['name']})"
            else: s=fill(R.choice(w2['not_'+lang]),lang,args2,shorts(args2)); c='never '+written(w2,args2)
            t=strip(say(w,args,lang)); low=s[:1].lower()+s[1:]
            if lang!='ja' and low.startswith(WITHOUT[lang]): t=end(t+R.choice([', ',' ',', '])+low)
            elif lang=='ja' and s.endswith(('に','ずに','ないで')) and R.random()<.5: t=end(s+('、' if R.random()<.7 else '')+say(w,args,lang))
            else:
                j=R.choice(BUT[lang]); t=end(t+j+(low if j.startswith((',',';',' ;')) else s))
            a=written(w,args)+' & '+c
        elif kind<.86:
            if R.random()<.3:
                x=args[0]
                if 'value' in x: continue
                t=end(fill(R.choice(LEAVE[lang]),lang,[x],shorts([x]))); a=f"untouched({x['name']})"
            else:
                f=[s for s in w['not_'+lang] if not s.lower().startswith(WITHOUT.get(lang,'#')) and not s.endswith(('ずに','に'))]
                if not f: continue
                t=end(fill(R.choice(f),lang,args,shorts(args))); a='never '+written(w,args)
        elif kind<.92:
            w2=R.choice(words); args2=pick(w2)
            if not args2 or written(w2,args2)==written(w,args): continue
            i,j=R.choice(FIRST[lang]); s=strip(say(w,args,lang)); s2=say(w2,args2,lang)
            t=end(i+(s if not i or lang=='de' else s[:1].lower()+s[1:])+('。' if lang=='ja' else '.')+j+(s2 if lang=='de' else s2[:1].lower()+s2[1:])); a=written(w,args)+' then '+written(w2,args2)
        elif kind<.95:
            tw=[x for x in args if x.get('twin')]
            if not tw: continue
            sh=[x is tw[0] for x in args]; t=end(fill(R.choice(w[lang]),lang,args,sh))
        elif kind<.98:
            i=R.randrange(len(args))
            if 'noun' not in args[i]: continue
            for _ in range(20):
                noun=anynoun(args[i]['cls'])
                if not ({x.lower() for k in LANGS for x in noun['ways'][k]}|{noun['name']})&used: break
            else: continue
            args[i]=dict(noun=noun,adj=None,name=noun['name'],cls=args[i]['cls']); t=end(say(w,args,lang))
        else:
            w2=R.choice([x for x in V if x not in words])
            a2=pick(w2)
            if not a2: continue
            t=end(say(w2,a2,lang))
        res.append(dict(suite=f'synthetic-{seed}-{n}',id=f's{seed}-{n}-{len(res)}',tags=[lang],fixed=[['system',sys_]],lead=lead,instruction=' '+' '.join(t.split()),answer=a))
    return res
with open(out,'w') as f:
    k=0
    for n in range(robots):
        for c in robot(n): f.write(json.dumps(c,ensure_ascii=False)+'\n'); k+=1
print(len(N),'nouns',len(V),'words',k,'cases')
