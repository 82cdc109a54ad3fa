"""Pickles that the version before the package's modules moved has written, by what they hold and by protocol."""

import base64
import zlib

# Mesh([(0, 0, 0), (1, 0, 0), (1, 1, 2.5)], [(0, 1, 2), (0, 2)]); a Scene and a Layer of it.
_TEXTS = {
    ("mesh", 0): (
        "c-qyJOHYI_5Xa-Hm-!@nk@UecG0`gr_uzq(NdsM|Bnvd9B<{ENBRGSsF~$RGJS?HjQ2x_-^aon0YHAO@?Ue#k`_g*{mcdpVJE@mua9z;"
        "V<1;+aWH}U#8#*;K%~<;ptN?E%JlYUF`l++WK<UBNK{w%^rE}#Gl&kg7kKRq%gN;r?==bmMZ4BF-;XVmybl%r`gt{jKYzo_=0-Hf`C^1"
        "Kl8IY2549O`rr{El;=NyLwym2vtCC1(#EpEdxMA4*ZB#<+PgOe;J-)#0PZm|{yyWK9o;V=&hBsf&$U?`ENiQ#o#^XuLDWU)?lb&n?{z|"
        "0^BI(`w76+vYXE_0$u#Hb-eL_(VM0}))w@D(A^A`+5)LP8Q)Qp`H@4G&WOfrrcW((Cn7tRP&vAtTB@CM)^U4Vf<8kQsfgZ0SaXD<KDiC"
        "I7mti}ljY{~@;dNyowyKjHlEB7Q>T2j`fc6A0b_Rf$%T"
    ),
    ("mesh", 4): (
        "c-nnY%}T^D7)<|Aa9O-4diJuXo;?T(y@<gce1Xz-lTE=kB|l(qUR*8Ywx18<Tlof>bX!?u**RqR^36;J@)~}Ad1!z+E_C&*sz!o2S`n2"
        "iC13+)zG`*$Lb<5pnn(sFd~{?tGb(tUaY`jo64vkp=Dg8$+r?SQ1&M2I<8mSL&T2D3O5R8%bg7&<8kF{_X1SGY0HZfZyaL{B(gJ%pz`+"
        "{W%tTAowZxfxdJX-@b{`n;2GTTr_^}ucj1&}oa*qz;`}Xkt#Ni#-ICjG3t`|G~Yh{Ns<5xRP*yX++7gKUDay0V(+{g}BeX^Kb<F_FHUr"
        "&E0#d+gjy4!?("
    ),
    ("scene", 0): (
        "c-rk&O^e$w5T)A|%KVaC8Z66}B`9>SIW&hZ_*5{q;%K+Tw(tjS{&jys-)Nm>(}t2=C^Th5EXMNFXht*hG}d;0U-Y#j47O{Bv7hYN_2eU"
        "3Sm&qW`?l+w<zVZ!rkgN&LAEHW>25dPwM9W)^|iJm`Iy$Dm-N{uwAlER@}liF^*~<ndq#Ox4p^<pozlGqmb@Vs)QAXrgy4lDW=&<o8%u"
        "JUhP?1)U$@v&B(%os*q80Vx-gTHZKuZXmxb;6df7~{vh4eEf8-&6u<9O3?dBffMMjHNMA%-#MGK4UKy_<_X~NJVui$1x`L2ZP0<r)&j$"
        "vyoSxQ(+p#+w%62c#oYPN_r<K9D2j9v1rhM;K`MR<Z1gS8STvyzm5ATI^2*Xz}LLE&MmWK0z=aKV%>Q-t52#~&ZhL0$Uz;^qJ3B~l+{9"
        "x6+6J;{_MMHLFYK_%|MC=w-fl0|NAyKgPN>tl)<C%;4GNz~2JysO7@9Km+Uv9hKfZs`*bJ`t2}`>rXv?RKa~Y@Wn0C<#OdrgKar?twXy"
        "6t*)LB#Hsq%mtEGVG`sgBYIj9za--GtvC<$<{D8obJC@J^`t=p-~JNbRL<c|IW^PtA-tGT_{7wH2Wn5VN7SBb#+rb0CwN^&Pv!N;<LmR"
        "GZ_kI~))w=DD8AnmyQq@i4n!UDU2(pvL%ws(DkM9+e!gd~&WB$8y+pfu(xDx)DB~>3f`lx>$b6B7&L~4`WV;<VS(&1|uQw1f8UWIa=SD"
        "#D*=j)pSg+*1M#rITa)$;<vpya4X@nqjMllTz9TB%kPVnSWq_mnNr88ctkGm9Yp219)#038m%Uxg2vAw&#)GoqAb152ud^db)8;LH$9h"
        "wIx`8GzbyZgE{TnC1k%P^Ojj3vz_I8@7@fX9K;"
    ),
    ("scene", 4): (
        "c-pN}!D`z;5S1;dPJ)}#5<;Pn974gp_*`hA216+o(V_VOA<3(Z!P+&uD_S1{$stY*bIass`c?gdWY)51NK6_^=AhBe&dknx^G<{7-@dm"
        "re04mnl3#_=W#8mN3c~Pc>96R+8J!TmNTeDG!@oTYveXCy4}+LvO-c{LM5ZNQbg+|5Q!S*W7`GCuQ)ygl!d+RF(^)^sl@|T7n%Hrwbvh"
        "&LCR*f58mp_^az_l8nS>oVs#C5g^3G}4%IJcAP%mmlK@`jh-e5Sgv#A>c+r>v(T-NtKwmwrF$KP+*mY>M8lr4s*HRL~EyeHZ7=Mj&=43"
        "*5?#5fwmBTzr31F(@*V<tr!27WATYOQwR?Z4Y8g#p6g&^f;87Fv~wDhea4p*bUm*RbQ5g58EEKk}KUy~Xg`{~>7NjSmJ6!J2pY@DAJKJ"
        "3D~=bsKowbY7{?3s-)9-;fWV7Q<ds)mr)Xy*b-=y0}_aZJ4Wx(uBSiBQkS3qjRb<^iviiY}T@cE*!#3=)m^Fr)!Dr{Zlme;}7x%kJoJs"
        "o+27JfcNnAgc=-`$@;g|^z$t"
    ),
    ("layer", 0): (
        "c-qxfO^?$s5ETnt=9lzBl*D$DN=R_3R0(?EkQ0*SI8JJm56gCzEx($dz)ZHgO9h7l;;>cYIOFH>8~f!&>)D;8H$7mZ=P5+L=s0_DDQtA"
        "_7J1jreoUOzaq%W3gE|=>-~-*jWuT>O7CS^cNeOfF#pnnwheLD>J~<AX)(NP`xitg0;u7AQsA9x4<;7Z~2}k%yjjN#U{5;CJ>w<{^+!m"
        "tCQp}uXIA>Z$cS@w5y-CIevnub^>7o?mm_Hz4YVQFqW3bt$l#3%JjqG#)Gf@Wz1#IdD?*-I@LaG_|O9EH4Fj2^fLXH&nbTPm`26H&C)5"
        "ep-L^-ZfcNKOx?9&vlj9`N17VEtFEe@7&I2`tGGFUHSl~>Tvgnp&+c}em2yxQ;Yo)3%bP_N$OQEl-^NC}M2pV4Wu9Gada)<0^BF+`C{7"
        "$=l?R0&23=vP%(R0S)4QUxPzvF(cMe<KN={);4DUJreJJro?z&KtsWdfTZ)&VShuF3uam3qqCW4G|QnpvS8JzOonBLvQ|{&~E-{(;ieL"
        "NJWB9U!aPxCCd~XLLI%D0+}H=A>a_|NsVYI0v*XIkESL{M47fX=!v2tL}wH^v{X|+5OfPWmL@5}j<#*hgzlRXZm^S)Uu_%FUW*KN`HE2"
        "!n&)5@rYrJQlA+e~Kp%nvZOWS#JH)J0+Q@Z;per|`@f0d3bZdMxcTd5Rf<dc6t&b~VJt~L&E!4Nx+t%VhNmTS;vFtJ<j2hfg;X@9)Y~|"
        "S+7mrdeSYgRvcVA#<2mH8{oMyP$PEiK?jSxhyNqzuh%j(J"
    ),
    ("layer", 4): (
        "c-nnZO>fjN5Z%oOZ7D?pp$f!->-Lf}2Sh9Fp@`5N_ydvGo~$i7PGmc!TL}pcl&<7khyU4Auf<LiwnA0s;PK47dGqA)kL1ryH0jN~S+-q"
        "yRyDfLT0w26!DN!GKpS-FmvF%=Jot&<apuyxVIa|MFFGNuP#&_i1WT+9AoqMjRfFN^l9S+k<yobhx@@Y-fHio5U(xNWu5MRZNgEAW-FZ"
        "5qHCcIVsev}iSlv+@n$sTXM=5p(xx#$%3+K}X{`O3>e4593e1ZI>OPO7@5SpUuJ+3eB>am-Cz@jKV-+Jqhd}492o`0G=YS)L4=SQC$p{"
        "L_7_^Y6c@BdTfgSRdc_muE=59xS4GRK2Y2mdf{>Vt#zd^UDX2Os^XGrGqTdfkrIM47N4EL@^U4Sq*0(bhjQuq7Cu-m8FwUr-XYlz_)aA"
        "BT_fgbT(%dB{^K6qMftv)tE*A#R5#ze6dA!AqCYMm8E<tbw81tq6s(PlXY?Vb&(xI|XgwY?IhBlt|KF6Izqjul`hM!G!;B36&zKPl;?f"
        "!Q;d0aXf?8@{)F5^Y{QRsf3h4aoY%GOC!z!i*Awq1<wrmmH"
    ),
}

PICKLES = {key: zlib.decompress(base64.b85decode(text)) for key, text in _TEXTS.items()}
